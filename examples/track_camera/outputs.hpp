#pragma once
#include "options.hpp"
#include <cstddef>
#include <filesystem>
#include <string>
#include <tilemesh/scene/rgbd_list.hpp>
#include <vector>

namespace track_camera {

/// The files in the folder of --out, in the order in which they are written.
inline constexpr char const* out_files[] = {"estimated.tum", "truth.tum", "paths.svg", "residual.ppm"};

/// The lists in the folder of --save-photos.
inline constexpr char const* photo_lists[] = {"associations.txt", "groundtruth.txt"};

/// "000012.png": the picture of a frame in the folders rgb and depth of --save-photos.
std::string photo_file(std::size_t frame);

/// Every file that the run reads: the map, the cameras, the trajectory, the lists of --photos and all pictures in them. Call it after the
/// readers: it throws `tilemesh::Error` as they do. `sized_by`: the pictures from which `scene::load_cameras` took sizes.
std::vector<std::filesystem::path> files_read(Options const& options, std::vector<tilemesh::scene::RgbdFrame> const& photos,
                                              std::vector<std::filesystem::path> const& sized_by);

/// Makes the folders of --out and --save-photos, and checks that every file of `frames` frames can be written. Throws `tilemesh::Error` if a
/// file cannot be written, or would replace another file of the run or a file in `read` (`report::DistinctFiles`). It writes nothing except
/// the folders.
void prepare_outputs(Options const& options, std::vector<std::filesystem::path> const& read, std::size_t frames);

} // namespace track_camera
