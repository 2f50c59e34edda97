#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/step_costs.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// The cost of moving messages in one step of a program, or in several successive steps of one kernel. It is given twice: hop by hop as the
/// program ran, and as a lower bound if every message went directly to the tile where it stays.
struct AnyToAnyStep {
    std::string kernel;
    std::uint32_t first = 0, last = 0; ///< of the program's steps
    std::uint64_t supersteps = 0;    ///< of the run
    std::uint64_t news_cycles = 0;   ///< exchange, sync and vote of these supersteps, as modelled
    std::uint64_t bound_cycles = 0;  ///< lower bound with an exchange from any tile to any tile
    bool replaced = false;           ///< false: nothing was sent and nothing settled, so both are equal
    std::uint64_t sent_bytes = 0;    ///< over all hops, messages and their heads
    std::uint64_t settled_bytes = 0; ///< bytes of messages at the end of their journeys
    std::uint64_t busiest_bytes = 0; ///< the most bytes that settle on one tile
    std::uint32_t busiest = 0;       ///< that tile; of equal ones the lowest
};

struct AnyToAny {
    std::vector<AnyToAnyStep> steps; ///< in program order
    std::uint64_t news_cycles = 0, bound_cycles = 0;
    std::uint64_t supersteps_replaced = 0; ///< supersteps of the steps that move messages
    std::uint64_t exchanges = 0;           ///< exchanges that would replace them: at most one per step
};

/// A lower bound for the cost of moving messages: the paper's ideal routing, in which a tile reads a Gaussian from any other tile's memory
/// and does not wait for it hop by hop. Compare it with the cost of the run's exchanges between neighbours.
///
/// A step of the program in which a message was sent or settled is bounded by one exchange without a vote:
///   exchange + the most bytes that settle on one tile * exchange_byte / 1,000, rounded up, + sync; 0 if nothing settles
/// Any other step keeps its cost. Successive steps of one kernel count as one, because Bloom's first superstep sends copies that its later
/// supersteps take. Compute is in neither column: the tiles' work of passing records on would disappear too.
///
/// It is a bound because no real fabric keeps the busiest receiver busy all the time, and a real tile would have to find out where the
/// records are. The bound is never above the cost of the same step with `ExchangeCost::live`, on two conditions: the step takes the
/// messages that it sends, as Route and Bloom do, and no mail is under way when the run begins. Bytes settle in the step that takes them
/// from their channel, whichever step sent them. Only bytes that kernels report count (Operations::settled_bytes).
///
/// If a renderer ran the program twice in a frame, the supersteps of both runs count as one step: one exchange of the sum of the bytes that
/// settle, although two would be needed. It is still a bound, but a looser one.
///
/// The sums are exact integers. Throws `Error` as model_cost does, for a trace of another grid, and if a step's bound exceeds 64 bits.
/// Cost: linear in the trace, and 8 bytes a tile.
TILEMESH_HOST AnyToAny any_to_any(CostModel const& model, Trace const& trace, Grid grid);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/any_to_any_code.hpp>
#endif
