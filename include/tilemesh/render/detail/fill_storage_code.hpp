#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/render/setup_choice.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {

TILEMESH_HOST SetupChoice fill_storage(SetupChoice c, Grid grid, Extent2 tile)
{
    std::uint64_t const pixels = std::uint64_t{tile.width} * tile.height, tiles = std::uint64_t{grid.width} * grid.height;
    if (tiles == 0 || tiles > c.machine.tiles)
        throw Error("a grid of " + std::to_string(grid.width) + " x " + std::to_string(grid.height) + " tiles (" + c.machine.name + " has " +
                    std::to_string(c.machine.tiles) + "); choose 1 to all of them");
    if (pixels == 0 || pixels > 0xffffffffu)
        throw Error("tiles of " + std::to_string(tile.width) + " x " + std::to_string(tile.height) +
                    " pixels (a tile has 1 to 4,294,967,295); choose another size");
    c.sizes.tile_pixels = static_cast<std::uint32_t>(pixels);
    c.sizes.storage = 1;
    ChoiceLedger const one(c);
    if (one.bytes > c.machine.sram_bytes) throw does_not_fit(c.machine, one.lines, one.bytes);
    c.sizes.storage = 2;
    auto const slot = sram_bytes_of(c) - one.bytes;
    c.sizes.storage = static_cast<std::uint32_t>(std::min<std::uint64_t>(1 + (c.machine.sram_bytes - one.bytes) / slot, 0x7fffffffu));
    return c;
}

}}} // namespace tilemesh::render
