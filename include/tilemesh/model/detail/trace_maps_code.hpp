#pragma once
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tilemesh/model/detail/trace_reading.hpp>
#include <tilemesh/model/trace_maps.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/heat_image.hpp>
#include <tilemesh/report/number_text.hpp>

namespace tilemesh { inline namespace v0_2 {
namespace model_detail {

/// The fill of the fullest channel side of each tile, in percent.
inline std::vector<double> fill_percent(Trace const& trace, Grid grid)
{
    auto fill = heat_map(trace, {}, grid, TileSum::channel_fill);
    for (auto& share : fill) share *= 100;
    return fill;
}

} // namespace model_detail

TILEMESH_HOST std::vector<TileMap> trace_maps(Trace const& trace, CostModel const& model, Grid grid)
{
    return {{"channel_fill", "Channel fill", "the fullest end of a channel, after the pass in which it was fullest", false,
             model_detail::fill_percent(trace, grid), "%"},
            {"busy_cycles", "Busy cycles", "modelled cycles that the tile computes", true, heat_map(trace, model, grid, TileSum::busy_cycles),
             "cycles"},
            {"idle_cycles", "Idle cycles", "modelled cycles that the tile waits for the slowest tile's compute", true,
             heat_map(trace, model, grid, TileSum::idle_cycles), "cycles"}};
}

TILEMESH_HOST std::vector<TileMap> trace_maps(Trace const& trace, Grid grid)
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

TILEMESH_HOST TileMap energy_map(Energy const& energy)
{
    return {"energy", "Energy", "joules of all that is counted", true, energy.joules_of_tile, "J"};
}

TILEMESH_HOST report::Image map_image(TileMap const& map, Grid grid, std::array<std::uint32_t, 2> tile_px)
{
    auto const common = std::max(std::gcd(tile_px[0], tile_px[1]), 1u);
    std::array<double, 2> const shape = {std::max(tile_px[0] / common, 1u) * 1.0, std::max(tile_px[1] / common, 1u) * 1.0};
    double const longer = std::max({shape[0] * grid.width, shape[1] * grid.height, 1.0});
    double const times = longer <= 640 ? std::floor(640 / longer) : 640 / longer; // a whole multiple of the shape in a small grid
    auto const cell = [&](double side) { return std::clamp(static_cast<std::uint32_t>(times * side + 0.5), 1u, 64u); };
    return report::heat_image(map.values, grid.width, grid.height, {0, report::finite_range(map.values).most}, cell(shape[0]), cell(shape[1]));
}

TILEMESH_HOST std::string maps_csv(std::span<TileMap const> maps, Grid grid)
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

TILEMESH_HOST std::string energy_csv(Energy const& energy, Grid grid)
{
    std::string text = "tile_x,tile_y,joules\n";
    for (std::uint32_t t = 0; t < grid.size(); ++t) {
        text += std::to_string(grid.tile(t).x()) + "," + std::to_string(grid.tile(t).y()) + "," + number_text(energy.joules_of_tile[t]) + '\n';
    }
    return text;
}

}} // namespace tilemesh
