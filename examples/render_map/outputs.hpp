#pragma once
#include "options.hpp"
#include "shots.hpp"
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace render_map {

/// "frame_0012.png" for frame 12 and ".png".
std::string frame_file(std::size_t frame, std::string const& extension);

/// "follow_17.csv" for --follow 17.
std::string follow_file(std::uint32_t id);

/// What --trace writes where a run makes no progress (--most-passes).
inline constexpr char const* no_progress_file = "no_progress.txt";

/// The file of --trace that has one line of counters for each frame.
inline constexpr char const* counters_file = "frames.csv";

/// Makes the folders for the pictures and the trace and looks whether everything can be written where it should: better now
/// than after an hour. Gives the pictures' folder back; throws `tilemesh::Error` where that is not so, and where the report
/// or the trace would overwrite another file of the run or one that the run reads.
std::filesystem::path prepare_outputs(Options const& options, std::size_t frames);

/// Standard output, checked: a text that does not arrive there throws `tilemesh::Error`, which ends with `remedy`.
void print(std::string const& text, char const* remedy);

} // namespace render_map
