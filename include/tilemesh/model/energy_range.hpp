#pragma once
#include <tilemesh/config.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/energy.hpp>

// What is published about energy, as a range: no number is invented, so an answer is a range too.
namespace tilemesh { inline namespace v0_2 {

/// Two energy models of the same events. A run's joules lie between theirs.
struct EnergyRange {
    EnergyModel least, most;
};

/// Mk2's events, from published energies. `least` has the fused multiplications of the operations whose flops are counted, and the bytes of
/// exchanges over routers; what no source has is left out: instructions, SRAM, wires, leakage. `most` has a card's design power on all tiles
/// for as long as the run lasts, which covers everything. Each number has its source.
TILEMESH_HOST EnergyRange mk2_energies();

struct JoulesRange {
    double least = 0, most = 0;
};
/// The joules of a run by both models. Throws `Error` as energy_of does.
TILEMESH_HOST JoulesRange joules_range(EnergyRange const& energies, CostModel const& model, Trace const& trace, Grid grid);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/energy_range_code.hpp>
#endif
