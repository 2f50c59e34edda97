#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/energy.hpp>
#include <tilemesh/model/trace_files.hpp>
#include <tilemesh/report/image.hpp>
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

/// The maps of a trace: the fill of the fullest channel end of each tile, the cycles that it computes, and the cycles that it waits.
TILEMESH_HOST std::vector<TileMap> trace_maps(Trace const& trace, CostModel const& model, Grid grid);

/// The maps of a trace without a cost model: the fill of the fullest channel end of each tile, the bytes that it sent, the number of its
/// runs, and the count of each operation that the program's kernels count.
TILEMESH_HOST std::vector<TileMap> trace_maps(Trace const& trace, Grid grid);

/// The joules of each tile.
TILEMESH_HOST TileMap energy_map(Energy const& energy);

/// The map as a picture for a file. A tile has the shape of `tile_px`, at least one pixel; the picture's longer side has about 640 pixels.
/// Colours go from dark blue for 0 over green to yellow for the largest value.
TILEMESH_HOST report::Image map_image(TileMap const& map, Grid grid, std::array<std::uint32_t, 2> tile_px = {1, 1});
/// One line per tile, with the numbers of all maps. Each map must have a value for every tile of the grid.
TILEMESH_HOST std::string maps_csv(std::span<TileMap const> maps, Grid grid);
/// One line per tile, with all digits of its joules.
TILEMESH_HOST std::string energy_csv(Energy const& energy, Grid grid);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/trace_maps_code.hpp>
#endif
