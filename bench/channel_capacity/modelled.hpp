#pragma once
#include "machine.hpp"
#include <cstdint>
#include <string>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/model/cost_parameters.hpp>

namespace channel_capacity {

/// The cost model of the sweep: the library's kernels on Mk2.
tilemesh::CostModel const& cost_model();

/// The modelled cycles of one frame, for any number of slots per channel. A machine that is built with c slots moves c slots of every
/// channel of a superstep, live or not. No other part of its cost depends on c if no limit binds.
struct Modelled {
    std::uint64_t rest = 0;           ///< compute, sync and votes
    std::uint64_t road = 0, beam = 0; ///< supersteps that exchange the channel
    std::uint64_t homes = 0;          ///< cycles of exchanges of the program of homes, on a machine that is built with its slots

    std::uint64_t exchange(std::uint32_t slots) const;
    std::uint64_t cycles(std::uint32_t slots) const { return rest + exchange(slots); }
    friend bool operator==(Modelled const&, Modelled const&) = default;
};

/// The cost of this trace's frame with channels of `slots` slots, its limit. `broken` gets a sentence if the trace's exchanges are not
/// those of such channels, if the cost does not add up to model_cost's cycles, or if one of the `exchanges` that sent messages is missing.
Modelled modelled(tilemesh::Trace const& trace, std::uint32_t slots, std::uint64_t exchanges, std::string& broken);
/// The cost of this trace's frame of the program of homes.
Modelled modelled_homes(tilemesh::Trace const& trace);

} // namespace channel_capacity
