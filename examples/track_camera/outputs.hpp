#pragma once
#include "options.hpp"
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace track_camera {

/// The files in the folder of --out, in the order in which they are written.
inline constexpr char const* out_files[] = {"estimated.tum", "truth.tum", "cameras.json", "paths.svg", "residual.png"};

/// The lists in the folder of --save-photos.
inline constexpr char const* photo_lists[] = {"associations.txt", "groundtruth.txt"};

/// "000012.png": the picture of a frame in the folders rgb and depth of --save-photos.
std::string photo_file(std::size_t frame);

/// Makes the folders of --out and --save-photos, and checks that every file of `frames` frames can be written. Throws `tilemesh::Error` if a
/// file cannot be written, or would replace another file of the run or a file in `read` (`report::DistinctFiles`). It writes nothing except
/// the folders.
void prepare_outputs(Options const& options, std::vector<std::filesystem::path> const& read, std::size_t frames);

} // namespace track_camera
