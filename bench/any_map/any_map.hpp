#pragma once
#include <array>
#include <common/options.hpp>
#include <common/scenes.hpp>
#include <cstdint>
#include <filesystem>
#include <numeric>
#include <string>
#include <vector>

namespace any_map {

struct Options : bench::Options {
    std::filesystem::path write;   ///< the folder of slots.svg; empty: not written
    std::filesystem::path picture; ///< a PNG file; not empty: this picture is all that the bench makes
    std::vector<std::string> maps; ///< empty: all
    std::uint32_t threads = 1;     ///< of every machine
};

enum class Program { anchored, paper, homes, unfolded, one_cut };
inline constexpr char const* program_names[] = {"anchored", "paper", "homes", "homes unfolded", "one cut"};
inline char const* to_string(Program p)
{
    return program_names[static_cast<std::uint32_t>(p)];
}

/// The columns of modelled time. Steps of the anchored program stand in the column of the step that does the same work.
enum class Part { host_link, project, tell, offer, deliver, sort, blend, advance, finish };
inline constexpr char const* part_names[] = {"host link", "project", "tell", "offer", "deliver", "sort", "blend", "advance", "finish"};
inline constexpr std::uint32_t parts = 9;

/// The frames after the first one of a recorded motion whose last frame is a view.
inline constexpr std::uint32_t motion_frames = 4;

/// One frame.
struct Row {
    std::string map, view;
    Program program = Program::homes;
    std::uint64_t gaussians = 0;
    std::uint32_t held = 0;       ///< K: splats that a tile holds; storage slots of the anchored program
    std::uint32_t slots = 0;      ///< of a channel end, and of each FIFO
    std::uint64_t chapters = 0;   ///< in which the records came; 0: all have homes
    std::uint64_t streamed_bytes = 0; ///< of records that the host sent for this frame
    std::uint64_t rounds = 0, exchanges = 0, hops = 0;
    std::uint64_t entries = 0;    ///< splats that arrived at a tile; copies of the anchored program
    std::uint64_t refused = 0;    ///< entries that found no room and come again in another round
    std::uint64_t missing = 0;    ///< records and copies that the picture lacks; a missing record counts once
    std::uint64_t sram_bytes = 0; ///< of a tile
    bool fits = true;             ///< into a tile of Mk2
    bool sweep = false;           ///< a row of the sweeps: its slots are not those of the setup
    double psnr_db = 0;           ///< against the exact picture; infinite for equal bits
    double host_ms = 0;
    std::array<std::uint64_t, parts> cycles{}; ///< modelled

    std::uint64_t all_cycles() const { return std::accumulate(cycles.begin(), cycles.end(), std::uint64_t{0}); }
};

/// Modelled milliseconds of Mk2.
double milliseconds(std::uint64_t cycles);
inline double modelled_ms(Row const& r)
{
    return milliseconds(r.all_cycles());
}
/// Renders all views of a map with all programs, and adds a row for each. With `sweeps`, it also renders one view with other slots. `broken`
/// gets a line for every picture of the program of homes that is not complete, and for every complete picture without the bits of the naive
/// whole-frame loop.
void measure(bench::Scene const& scene, Options const& options, bool sweeps, std::vector<Row>& rows, std::vector<std::string>& broken);

std::string csv(std::vector<Row> const& rows);
/// A Markdown table of the rows that are not of a sweep, a line for each view and program.
std::string view_table(std::vector<Row> const& rows);
/// A Markdown table of the modelled milliseconds of each step of the program of homes.
std::string step_table(std::vector<Row> const& rows);
/// A Markdown table of the sweeps of a map.
std::string sweep_table(std::vector<Row> const& rows);
/// The conclusions from the rows, one sentence or two each.
std::vector<std::string> findings(std::vector<Row> const& rows);
/// Writes slots.svg into an existing folder: modelled time against slots.
void write_plot(std::filesystem::path const& folder, std::vector<Row> const& rows);

/// Writes the picture of the first page: a part of playbot_250k, on anchored tiles, which lack records, and with homes. Throws Error
/// if the map is not there.
void write_picture(Options const& options);

} // namespace any_map
