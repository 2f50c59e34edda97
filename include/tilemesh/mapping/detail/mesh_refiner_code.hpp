#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/mapping/mesh_refiner.hpp>
#include <tilemesh/splat/footprint.hpp>
#include <tilemesh/splat/map/insert.hpp>
#include <tilemesh/splat/map/regions.hpp>
#include <tilemesh/splat/project_all.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace mapping::detail {

inline Resting rest(std::vector<splat::Gaussian> const& records, splat::View const& view, splat::Tiling const& tiling, Grid grid)
{
    Resting out;
    out.tile.resize(records.size());
    std::vector<splat::Splat> splats(records.size());
    splat::project_all(records.data(), static_cast<std::uint32_t>(records.size()), view, tiling, splats.data());
    std::vector<std::uint32_t> resting(grid.size(), 0), entries(grid.size(), 0);
    for (std::size_t k = 0; k < records.size(); ++k) {
        auto const& s = splats[k];
        if (!s.visible()) continue;
        ++resting[out.tile[k] = grid.index_of(s.anchor)];
        auto const box = splat::tiles_of(s, tiling);
        for (std::uint32_t y = box.first.y(); y <= box.last.y(); ++y)
            for (std::uint32_t x = box.first.x(); x <= box.last.x(); ++x) ++entries[grid.index_of(TileId::at(x, y))];
    }
    std::size_t const even = (records.size() + grid.size() - 1) / grid.size();
    std::uint32_t next = 0;
    for (std::size_t k = 0; k < records.size(); ++k) {
        if (splats[k].visible()) continue;
        while (resting[next] >= even) ++next; // a tile below the mean exists as long as a record is left
        ++resting[out.tile[k] = next];
        ++entries[next];
    }
    out.most_records = *std::max_element(resting.begin(), resting.end());
    out.most_entries = *std::max_element(entries.begin(), entries.end());
    return out;
}

inline void expect_tiles(splat::Camera const& camera, splat::Tiling const& tiling, Grid grid)
{
    if (tiling.columns <= grid.width && tiling.rows <= grid.height) return;
    throw Error("a picture of " + by(camera.width, camera.height) + " pixels does not fit the mesh (it has " +
                by(tiling.columns, tiling.rows) + " tiles of " + by(tiling.tile_width, tiling.tile_height) + " pixels, the grid " +
                by(grid.width, grid.height) + "); take a larger grid, larger tiles or smaller pictures");
}

inline void expect_room(MachineSize const& machine, std::size_t records, Resting const& resting, splat::map::MapSizes const& sizes,
                        std::uint32_t record_bytes)
{
    if (resting.most_entries <= sizes.entries) return;
    std::uint32_t const entry = splat::map::entry_bytes(sizes.walkers);
    auto const bytes = [entry](std::uint32_t entries) { return std::to_string(std::uint64_t{entries} * entry); };
    throw Error("a map of " + std::to_string(records) + " Gaussians does not fit the tiles of " + machine.name + " (the fullest holds " +
                std::to_string(resting.most_records) + " records of " + std::to_string(record_bytes) + " bytes, and its " +
                std::to_string(resting.most_entries) + " splats of " + std::to_string(entry) + " bytes in the reference view take " +
                bytes(resting.most_entries) + " bytes; " + bytes(sizes.entries) +
                " are left); take smaller tiles, fewer slots of channels or a smaller map");
}

inline void expect_growable(MeshRefineOptions const& options)
{
    auto const cell = options.insert.cell;
    auto const& tile = options.refine.view.tile;
    if (cell == 0 || tile.tile_width % cell != 0)
        throw Error("a map cannot grow in cells of " + std::to_string(cell) + " pixels on tiles of " +
                    by(tile.tile_width, tile.tile_height) +
                    " (a tile adds up whole columns of cells); take cells whose side divides the width of a tile");
    if (options.record_slots == 0)
        throw Error("a map cannot grow on tiles without a free slot (record_slots is 0); give the records that a tile may hold");
}

inline void expect_keyframe(splat::Camera const& camera, std::uint32_t cell, std::uint32_t keyframe, std::uint32_t last)
{
    auto const grid = splat::map::CellGrid::of(camera.width, camera.height, cell);
    if (std::uint64_t{grid.columns} * grid.rows > splat::map::most_cells)
        throw Error("a keyframe of " + by(camera.width, camera.height) + " pixels has too many cells (at most " +
                    std::to_string(splat::map::most_cells) + " have ids); take smaller pictures or larger cells");
    if (keyframe <= last || keyframe > splat::map::most_keyframes)
        throw Error("a keyframe cannot have the number " + std::to_string(keyframe) + " (the map has ids of keyframe " +
                    std::to_string(last) + ", and the last number is " + std::to_string(splat::map::most_keyframes) +
                    "); number keyframes from 1 on, each above the one before");
}

inline std::vector<std::uint32_t> rows_by_id(scene::Map const& map, std::uint32_t degree)
{
    if (map.sh_degree != degree)
        throw Error("a map with harmonics of degree " + std::to_string(map.sh_degree) +
                    " cannot be refined on a mesh with states of degree " + std::to_string(degree) +
                    " (the optimiser's states hold the harmonics); take splat::map::Shaded of the map's degree, or mapping::Refiner");
    std::vector<std::uint32_t> rows(map.gaussians.size());
    std::iota(rows.begin(), rows.end(), 0u);
    auto const id = [&](std::uint32_t row) { return map.gaussians[row].id; };
    std::sort(rows.begin(), rows.end(), [&](auto a, auto b) { return id(a) < id(b); });
    auto const twice = std::adjacent_find(rows.begin(), rows.end(), [&](auto a, auto b) { return id(a) == id(b); });
    if (twice != rows.end())
        throw Error("two Gaussians of the map have the id " + std::to_string(static_cast<std::uint32_t>(id(*twice))) +
                    " (ids decide the order of equal depths); give each its own");
    return rows;
}

inline void put_in_order(scene::Map& map, std::vector<std::uint32_t> const& rows)
{
    std::size_t const words = map.gaussians.empty() ? 0 : map.harmonics.size() / map.gaussians.size();
    std::vector<splat::Gaussian> gaussians;
    std::vector<float> harmonics;
    gaussians.reserve(rows.size()), harmonics.reserve(map.harmonics.size());
    for (auto const row : rows) {
        gaussians.push_back(map.gaussians[row]);
        auto const from = map.harmonics.begin() + static_cast<std::ptrdiff_t>(words * row);
        harmonics.insert(harmonics.end(), from, from + static_cast<std::ptrdiff_t>(words));
    }
    map.gaussians = std::move(gaussians), map.harmonics = std::move(harmonics);
}

}}} // namespace tilemesh::mapping::detail
