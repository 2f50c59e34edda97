#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/render/setup_choice.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {

namespace detail {
/// The slots of a list on another machine: they shrink as the SRAM without the code does.
TILEMESH_HOST std::uint32_t shrunk(std::uint32_t slots, MachineSize const& from, MachineSize const& to)
{
    auto const data = [](MachineSize const& m) { return std::uint64_t{m.sram_bytes} - std::min(m.code_bytes, m.sram_bytes); };
    if (slots == dynamic_capacity || slots == 0 || data(to) >= data(from)) return slots;
    return static_cast<std::uint32_t>(std::max<std::uint64_t>(slots * data(to) / data(from), 1));
}
} // namespace detail

TILEMESH_HOST SetupChoice on_machine(SetupChoice c, MachineSize const& machine, std::uint32_t tile_pixels, std::uint32_t channel_slots)
{
    auto const of = c.machine;
    c.machine = machine;
    if (c.sizes.tile_pixels >= tile_pixels && sram_bytes_of(c) <= machine.sram_bytes) return c;
    c.sizes.tile_pixels = std::max(tile_pixels, 1u);
    for (auto* slots : {&c.sizes.road, &c.sizes.beam, &c.sizes.waiting}) {
        if (*slots == 0 || *slots == dynamic_capacity) continue;
        *slots = channel_slots == 0 ? detail::shrunk(*slots, of, machine) : std::min(*slots, channel_slots);
    }
    c.sizes.storage = 1;
    auto const one = sram_bytes_of(c);
    if (one >= machine.sram_bytes) return c;
    c.sizes.storage = 2;
    auto const slot = sram_bytes_of(c) - one;
    c.sizes.storage = static_cast<std::uint32_t>(std::min<std::uint64_t>(1 + (machine.sram_bytes - one) / slot, 0x7fffffffu));
    return c;
}

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
