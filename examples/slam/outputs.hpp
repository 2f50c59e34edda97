#pragma once
#include "options.hpp"
#include <filesystem>
#include <vector>

namespace slam_program {

/// The files in the folder of --out, in the order in which they are written.
inline constexpr char const* out_files[] = {"map.ply", "estimated.tum", "truth.tum", "cameras.json", "keyframes.json"};

/// Makes the folder of --out, and checks that every file can be written. Throws `tilemesh::Error` if a file cannot be written, or would
/// replace another file of the run or a file in `read` (`report::DistinctFiles`). It writes nothing except the folder.
void prepare_outputs(Options const& options, std::vector<std::filesystem::path> const& read);

} // namespace slam_program
