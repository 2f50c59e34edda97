#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/render/homes_layout.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/splat/homes/program.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {

namespace detail {
using HomesLedger = SramLedger<splat::homes::Frame<splat::homes::ValuePolicies<>>>;

/// The slots of a list on another machine: they shrink as the SRAM without the code does.
TILEMESH_HOST std::uint32_t shrunk(std::uint32_t slots, MachineSize const& from, MachineSize const& to)
{
    auto const data = [](MachineSize const& m) { return std::uint64_t{m.sram_bytes} - std::min(m.code_bytes, m.sram_bytes); };
    if (slots == dynamic_capacity || slots == 0 || data(to) >= data(from)) return slots;
    return static_cast<std::uint32_t>(std::max<std::uint64_t>(slots * data(to) / data(from), 1));
}
TILEMESH_HOST void fill(Setup& setup, std::uint32_t splat::Sizes::*list, std::uint64_t bytes_with_one)
{
    setup.sizes.*list = 2;
    auto const slot = sram_bytes_of(setup) - bytes_with_one;
    setup.sizes.*list =
        static_cast<std::uint32_t>(std::min<std::uint64_t>(1 + (setup.machine.sram_bytes - bytes_with_one) / slot, 0x7fffffffu));
}
} // namespace detail

TILEMESH_HOST std::vector<machine::Region> ledger_of(Setup const& setup)
{
    std::vector<machine::Region> lines;
    auto const add = [&](auto const& all) {
        for (auto const& line : all)
            if (line.what != nullptr) lines.push_back(line);
    };
    if (setup.program == splat::Program::homes) add(detail::HomesLedger::lines(setup.machine, setup));
    else add(splat::FrameLedger::lines(setup.machine, setup));
    return lines;
}
TILEMESH_HOST std::uint64_t sram_bytes_of(Setup const& setup)
{
    return setup.program == splat::Program::homes ? detail::HomesLedger::bytes(setup.machine, setup) : splat::frame_bytes(setup);
}

TILEMESH_HOST void check_setup(Setup const& setup)
{
    check_workers(setup.machine, splat::Work::max_workers);
    auto const bytes = sram_bytes_of(setup);
    if (bytes > setup.machine.sram_bytes) throw does_not_fit(setup.machine, ledger_of(setup), bytes);
    if (setup.routes && setup.holds && setup.sizes.waiting == 0)
        throw Error("a setup that holds needs FIFOs (without one no credit is ever given and nothing moves); give Sizes::waiting room for at "
                    "least one message");
}

TILEMESH_HOST Setup on_machine(Setup setup, MachineSize const& machine, std::uint32_t tile_pixels, std::uint32_t channel_slots)
{
    bool const homes = setup.program == splat::Program::homes;
    auto const of = setup.machine;
    setup.machine = machine;
    if (!homes) {
        if (setup.sizes.tile_pixels >= tile_pixels && sram_bytes_of(setup) <= machine.sram_bytes) return setup;
        setup.sizes.tile_pixels = std::max(tile_pixels, 1u);
    }
    for (auto* slots : {&setup.sizes.road, &setup.sizes.beam, &setup.sizes.waiting}) {
        if (*slots == 0 || *slots == dynamic_capacity) continue;
        *slots = channel_slots == 0 ? detail::shrunk(*slots, of, machine) : std::min(*slots, channel_slots);
    }
    if (homes) return setup;
    setup.sizes.storage = 1;
    auto const one = sram_bytes_of(setup);
    if (one < machine.sram_bytes) detail::fill(setup, &splat::Sizes::storage, one);
    return setup;
}

TILEMESH_HOST Setup fill_storage(Setup setup, Grid grid, Extent2 tile)
{
    if (setup.program == splat::Program::homes) return detail::fill_homes(setup, grid, tile);
    std::uint64_t const pixels = std::uint64_t{tile.width} * tile.height, tiles = std::uint64_t{grid.width} * grid.height;
    if (tiles == 0 || tiles > setup.machine.tiles)
        throw Error("a grid of " + std::to_string(grid.width) + " x " + std::to_string(grid.height) + " tiles (" + setup.machine.name + " has " +
                    std::to_string(setup.machine.tiles) + "); choose 1 to all of them");
    if (pixels == 0 || pixels > 0xffffffffu)
        throw Error("tiles of " + std::to_string(tile.width) + " x " + std::to_string(tile.height) +
                    " pixels (a tile has 1 to 4,294,967,295); choose another size");
    setup.sizes.tile_pixels = static_cast<std::uint32_t>(pixels);
    setup.sizes.storage = 1;
    auto const one = sram_bytes_of(setup);
    if (one > setup.machine.sram_bytes) throw does_not_fit(setup.machine, ledger_of(setup), one);
    detail::fill(setup, &splat::Sizes::storage, one);
    return setup;
}

}}} // namespace tilemesh::render
