#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/detail/trace_reading.hpp>
#include <tilemesh/model/energy.hpp>
#include <tilemesh/model/trace_files.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/heat_image.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/number_text.hpp>
#include <utility>
#include <vector>

/// Maps of the grid from a trace of any program: numbers for each tile, as pictures and as CSV.
namespace tilemesh { inline namespace v0_2 {

/// A number for each tile, which the page shows as a map of the grid.
struct TileMap {
    std::string name;           ///< name of a file and of a column: letters and `_`
    std::string title, what;    ///< the heading, and a phrase that explains the numbers
    bool in_total = true;       ///< does the sum over all tiles have a meaning?
    std::vector<double> values; ///< one per tile, finite, not below 0
    std::string unit{};         ///< unit of the numbers: "cycles"
};

namespace model_detail {
/// The fill of the fullest channel side of each tile, in percent.
inline std::vector<double> fill_percent(Trace const& trace, Grid grid)
{
    auto fill = heat_map(trace, {}, grid, TileSum::channel_fill);
    for (auto& share : fill) share *= 100;
    return fill;
}
} // namespace model_detail

/// The maps of a trace: the fill of the fullest channel end of each tile, the cycles that it computes, and the cycles that it waits.
inline std::vector<TileMap> trace_maps(Trace const& trace, CostModel const& model, Grid grid)
{
    return {{"channel_fill", "Channel fill", "the fullest end of a channel, after the pass in which it was fullest", false,
             model_detail::fill_percent(trace, grid), "%"},
            {"busy_cycles", "Busy cycles", "modelled cycles that the tile computes", true, heat_map(trace, model, grid, TileSum::busy_cycles),
             "cycles"},
            {"idle_cycles", "Idle cycles", "modelled cycles that the tile waits for the slowest tile's compute", true,
             heat_map(trace, model, grid, TileSum::idle_cycles), "cycles"}};
}

/// The maps of a trace without a cost model: the fill of the fullest channel end of each tile, the bytes that it sent, the number of its
/// runs, and the count of each operation that the program's kernels count.
inline std::vector<TileMap> trace_maps(Trace const& trace, Grid grid)
{
    std::vector<TileMap> maps = {
        {"channel_fill", "Channel fill", "the fullest end of a channel, after the pass in which it was fullest", false,
         model_detail::fill_percent(trace, grid), "%"},
        {"sent_bytes", "Bytes sent", "bytes of messages and their heads that the tile sent", true, heat_map(trace, {}, grid, TileSum::sent_bytes),
         "bytes"},
        {"tile_runs", "Kernel runs", "passes in which the tile ran", true, heat_map(trace, {}, grid, TileSum::tile_runs), "runs"}};
    for (auto const& name : model_detail::OperationColumns(trace).names)
        maps.push_back({"operation_" + std::to_string(maps.size() - 3), "Operation " + name, "how often the tile did it", true,
                        heat_map(trace, grid, name), name});
    return maps;
}

/// The joules of each tile.
inline TileMap energy_map(Energy const& energy)
{
    return {"energy", "Energy", "joules of all that is counted", true, energy.joules_of_tile, "J"};
}

/// The map as a picture for a file. A tile has the shape of `tile_px`, at least one pixel; the picture's longer side has about 640 pixels.
/// Colours go from dark blue for 0 over green to yellow for the largest value.
inline report::Image map_image(TileMap const& map, Grid grid, std::array<std::uint32_t, 2> tile_px = {1, 1})
{
    auto const common = std::max(std::gcd(tile_px[0], tile_px[1]), 1u);
    std::array<double, 2> const shape = {std::max(tile_px[0] / common, 1u) * 1.0, std::max(tile_px[1] / common, 1u) * 1.0};
    double const longer = std::max({shape[0] * grid.width, shape[1] * grid.height, 1.0});
    double const times = longer <= 640 ? std::floor(640 / longer) : 640 / longer; // a whole multiple of the shape in a small grid
    auto const cell = [&](double side) { return std::clamp(static_cast<std::uint32_t>(times * side + 0.5), 1u, 64u); };
    return report::heat_image(map.values, grid.width, grid.height, {0, report::finite_range(map.values).most}, cell(shape[0]), cell(shape[1]));
}
/// One line per tile, with the numbers of all maps. Each map must have a value for every tile of the grid.
inline std::string maps_csv(std::span<TileMap const> maps, Grid grid)
{
    std::string text = "tile_x,tile_y";
    for (auto const& map : maps) text.append(",").append(map.name);
    text += '\n';
    for (std::uint32_t t = 0; t < grid.size(); ++t) {
        text += std::to_string(grid.tile(t).x()) + "," + std::to_string(grid.tile(t).y());
        for (auto const& map : maps) text.append(",").append(report::plain_number(map.values[t]));
        text += '\n';
    }
    return text;
}
/// One line per tile, with all digits of its joules.
inline std::string energy_csv(Energy const& energy, Grid grid)
{
    std::string text = "tile_x,tile_y,joules\n";
    std::array<char, 32> digits{}; // room for the shortest text that reads back as the same double: at most 24 characters
    for (std::uint32_t t = 0; t < grid.size(); ++t) {
        auto const end = write_number(digits.data(), digits.data() + digits.size(), energy.joules_of_tile[t]);
        text += std::to_string(grid.tile(t).x()) + "," + std::to_string(grid.tile(t).y()) + ",";
        text.append(digits.data(), end.ptr) += '\n';
    }
    return text;
}

}} // namespace tilemesh
