#pragma once
#include "machine.hpp"
#include <cstdint>
#include <string>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/model/cost_parameters.hpp>

namespace channel_capacity {

/// The cost model of the sweep: our kernels on Mk2.
tilemesh::CostModel const& cost_model();

/// Modelled cycles of one frame, for any number of slots a channel. A machine that is built with c slots moves c slots of every channel
/// of a superstep, live or not; nothing else of its cost depends on c where no limit binds.
struct Modelled {
    std::uint64_t rest = 0;           ///< compute, sync and votes
    std::uint64_t road = 0, beam = 0; ///< supersteps that exchange it

    std::uint64_t exchange(std::uint32_t slots) const;
    std::uint64_t cycles(std::uint32_t slots) const { return rest + exchange(slots); }
    friend bool operator==(Modelled const&, Modelled const&) = default;
};

/// What the frame of this trace costs with channels of `slots`, its limit. `broken` is set to a sentence where the trace's exchanges are
/// not those of such channels, where it does not add up to model_cost's cycles, or lacks one of `exchanges` that sent something.
Modelled modelled(tilemesh::Trace const& trace, std::uint32_t slots, std::uint64_t exchanges, std::string& broken);

} // namespace channel_capacity
