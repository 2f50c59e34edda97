#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/energy_range.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

TILEMESH_HOST EnergyRange mk2_energies()
{
    using Work = KernelWork;
    // Tenths of a flop of an operation of mk2(); others have none.
    constexpr std::pair<std::string_view, std::uint64_t> flops[] = {{"projection", 10 * Work::projection_flops},
                                                                    {"pair", Work::tenth_flops_a_pair},
                                                                    {"moving_pair", Work::tenth_flops_a_tracked_pair + 10 * Work::moving_flops},
                                                                    {"moving_depth", 10 * Work::moving_depth_flops},
                                                                    {"splat_motions", 10 * Work::motion_flops},
                                                                    {"row", 10 * (Work::adding_flops + Work::row_flops)},
                                                                    {"gradient", 10 * (Work::adding_flops + Work::gradient_flops)},
                                                                    {"mean", 10 * Work::mean_flops}};
    constexpr std::uint64_t multiplication = 1'310; // fJ at 7 nm
    constexpr std::uint64_t watts = 185, tiles = 1472, clock_khz = 1'325'000;
    constexpr std::uint64_t tile_cycle = (watts * 1'000'000'000'000 + tiles * clock_khz - 1) / (tiles * clock_khz); // fJ, rounded up
    EnergyRange range;
    range.least.name = "mk2, at least";
    range.most.name = "mk2, at most";
    std::string const covered = "document: in the power of tile_cycle", none = "guess: no source has it; 0 leaves it out";
    for (auto const& price : mk2().prices) {
        std::uint64_t tenths = 0;
        for (auto const& [operation, n] : flops)
            if (operation == price.operation) tenths = n;
        set_energy(range.least, price.operation, tenths * multiplication / 20,
                   tenths == 0 ? none
                               : "document: 1.31 pJ a multiplication of 32-bit floats at 7 nm (Jouppi et al., ISCA 2021), one for two flops; memory "
                                 "and instructions are left out");
        set_energy(range.most, price.operation, 0, covered);
    }
    for (auto const* event : {sent_byte_event, capacity_byte_event}) {
        set_energy(range.least, event, 150, "document: 0.15 pJ a byte and hop of a router at 12 nm, without wires (FlooNoC, IEEE TVLSI 33, 2025)");
        set_energy(range.most, event, 0, covered);
    }
    set_energy(range.least, tile_cycle_event, 0, none);
    set_energy(range.most, tile_cycle_event, tile_cycle, "document: 185 W of a C600 (its datasheet) on 1,472 tiles at 1.325 GHz");
    return range;
}

TILEMESH_HOST JoulesRange joules_range(EnergyRange const& energies, CostModel const& model, Trace const& trace, Grid grid)
{
    return {energy_of(energies.least, model, trace, grid).joules, energy_of(energies.most, model, trace, grid).joules};
}

}} // namespace tilemesh
