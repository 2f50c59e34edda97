#pragma once
#include "options.hpp"
#include "shots.hpp"
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>
#include <tilemesh/report/whole_file.hpp>
#include <tilemesh/report/y4m.hpp>
#include <vector>

namespace render_map {

/// "frame_0012.png" for frame 12 and ".png".
std::string frame_file(std::size_t frame, std::string const& extension);

/// The path of a picture's `frame_file`, in the folder of --out. `prepare_outputs` uses the same list of pictures. An extension that the
/// options do not ask for throws `std::logic_error`.
std::filesystem::path frame_path(Options const& options, std::size_t frame, std::string const& extension);

/// The ends of the names of a frame's pictures, ".png" first.
std::vector<std::string> picture_extensions(Options const& options);

/// The names of the pictures of a frame, in the order in which they are written.
std::vector<std::string> picture_files(Options const& options, std::size_t frame);

/// "follow_17.csv" for --follow 17.
std::string follow_file(std::uint32_t id);

/// The file that --trace writes if a run makes no progress (--most-passes).
inline constexpr char const* no_progress_file = "no_progress.txt";

/// The file of --trace that has one line of counters for each frame.
inline constexpr char const* counters_file = "frames.csv";

/// The end of the file of --trace that has one line for each round of each tile of a frame of homes.
inline constexpr char const* rounds_end = ".rounds.csv";

/// Every file that the run reads, the photographs of the shots too. For a COLMAP model: both files. `sized_by`: of `make_shots`.
std::vector<std::filesystem::path> files_read(Options const& options, std::vector<Shot> const& shots,
                                              std::vector<std::filesystem::path> const& sized_by);

/// With --report, files must survive a power loss, because the report says that they were written.
tilemesh::report::Outlasts outlasts(Options const& options);

/// Further files of --trace.
inline constexpr char const* page_file = "report.html";
inline constexpr char const* model_file = "model.txt";

/// Does --trace write a file of that name, in a run with `frames` frames?
bool is_of_trace(std::string_view name, Options const& options, std::size_t frames);

/// Makes the folders for the pictures and the trace, and checks before the run that every file can be written. Returns the folder of the
/// pictures. Throws `tilemesh::Error` if a file cannot be written, or would replace another file of the run or a file that the run reads
/// (`report::DistinctFiles`). It writes nothing except the folders. `read`: of `files_read`.
std::filesystem::path prepare_outputs(Options const& options, std::vector<Shot> const& shots,
                                      std::vector<std::filesystem::path> const& read);

/// Opens the video of --video; null without the option. All shots have one size (`check_sizes`). Throws `tilemesh::Error` if it cannot be
/// written.
std::unique_ptr<tilemesh::report::Y4mVideo> open_video(Options const& options, std::vector<Shot> const& shots);

/// "walk.y4m, 60 frames at 30 per second", for the summary.
std::string video_text(Options const& options, std::size_t frames);

/// The stream of the summary: standard output, or standard error if standard output has the video.
std::ostream& text_stream(Options const& options);

} // namespace render_map
