#pragma once
#include "options.hpp"
#include <filesystem>
#include <tilemesh/scene/rgbd_list.hpp>
#include <vector>

namespace slam_program {

/// The files in the folder of --out, in the order in which they are written.
inline constexpr char const* out_files[] = {"map.ply", "estimated.tum", "truth.tum"};

/// Every file that the run reads: maps, cameras, the trajectory, the lists of --photos and all pictures in them. Call it after the readers:
/// it throws `tilemesh::Error` as they do. `sized_by`: the pictures from which `scene::load_cameras` took sizes.
std::vector<std::filesystem::path> files_read(Options const& options, std::vector<tilemesh::scene::RgbdFrame> const& photos,
                                              std::vector<std::filesystem::path> const& sized_by);

/// Makes the folder of --out, and checks that every file can be written. Throws `tilemesh::Error` if a file cannot be written, or would
/// replace another file of the run or a file in `read` (`report::DistinctFiles`). It writes nothing except the folder.
void prepare_outputs(Options const& options, std::vector<std::filesystem::path> const& read);

} // namespace slam_program
