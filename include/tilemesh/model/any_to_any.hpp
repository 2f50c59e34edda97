#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/detail/trace_reading.hpp>
#include <tilemesh/model/step_costs.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// What moving costs in one step of a program, or in several of one kernel that follow each other: hop by hop as it ran, and
/// at least if every message went straight to where it stays.
struct AnyToAnyStep {
    std::string kernel;
    std::uint32_t first = 0, last = 0; ///< of the program's steps
    std::uint64_t supersteps = 0;    ///< of the run
    std::uint64_t news_cycles = 0;   ///< their exchange, sync and vote, as modelled
    std::uint64_t bound_cycles = 0;  ///< not less for an exchange from any tile to any tile
    bool replaced = false;           ///< false: nothing was sent and nothing settled, both are the same
    std::uint64_t sent_bytes = 0;    ///< over all hops, messages and their heads
    std::uint64_t settled_bytes = 0; ///< of messages where their journeys end
    std::uint64_t busiest_bytes = 0; ///< that settle on one tile, at most
    std::uint32_t busiest = 0;       ///< that tile; of equals the lowest
};

struct AnyToAny {
    std::vector<AnyToAnyStep> steps; ///< in program order
    std::uint64_t news_cycles = 0, bound_cycles = 0;
    std::uint64_t supersteps_replaced = 0; ///< of the steps that move anything
    std::uint64_t exchanges = 0;           ///< that would take their place: at most one a step
};

/// The paper's ideal routing, in which a tile reads a Gaussian from any other tile's memory instead of waiting for it to come hop
/// by hop, as a bound beside what the run's exchanges between neighbours cost.
///
/// A step of the program in which something was sent or settled is bounded by one exchange without a vote:
///   exchange + the most bytes that settle on one tile * exchange_byte / 1,000, rounded up, + sync; 0 where nothing settles
/// Any other step keeps its cost. Steps of one kernel that follow each other count as one: Bloom's first superstep sends what its
/// others take. Compute is in neither column: what tiles do to pass records on would go, too.
///
/// A bound, because a fabric that keeps the busiest receiver busy all the time and asks nobody where records are does not
/// exist. It is never above what the same step costs with `ExchangeCost::live`, where the step takes what it sends, as Route
/// and Bloom do, and no mail is under way when the run begins: bytes settle in the step that takes them from their channel,
/// whoever paid for sending them. And only as far as kernels say so (Operations::settled_bytes).
///
/// Where the trace is of a renderer's frame that ran the program twice, both runs' supersteps of a step count as one step: one
/// exchange of the sum of what settles, where two would be needed. Still a bound, but a looser one.
///
/// Exact integers. Throws `Error` as model_cost does, for a trace of another grid, and where a step's bound passes 64 bits. Cost:
/// linear in the trace, and 8 bytes a tile.
inline AnyToAny any_to_any(CostModel const& model, Trace const& trace, Grid grid)
{
    model_detail::check_trace(trace, grid);
    AnyToAny out;
    auto const costs = step_costs(trace, model_cost(model, trace, grid));
    for (std::uint32_t i = 0; i < costs.size(); ++i) {
        auto const& s = costs[i];
        if (i == 0 || s.kernel != costs[i - 1].kernel) {
            out.steps.emplace_back();
            out.steps.back().kernel = s.kernel;
            out.steps.back().first = i;
        }
        auto& step = out.steps.back();
        step.last = i;
        step.supersteps += s.supersteps;
        step.news_cycles += s.exchange + s.sync + s.vote;
    }
    constexpr auto most = std::numeric_limits<std::uint64_t>::max();
    std::vector<std::uint64_t> settled;
    for (auto& step : out.steps) {
        auto const refuse = [&] {
            throw Error("an exchange from any tile to any tile cannot be modelled (step " + std::to_string(step.first) + ", " +
                        step.kernel + ": its cycles pass 64 bits); give the cost model smaller numbers");
        };
        settled.assign(grid.size(), 0);
        for (auto const& s : trace.supersteps) {
            if (s.step < step.first || s.step > step.last) continue;
            step.replaced = step.replaced || s.sent;
            for (auto const& t : s.tiles) {
                step.sent_bytes += model_detail::all_sent(t);
                step.settled_bytes += t.operations.settled_bytes;
                settled[t.tile] += t.operations.settled_bytes;
            }
        }
        step.replaced = step.replaced || step.settled_bytes != 0;
        if (!step.replaced) {
            step.bound_cycles = step.news_cycles;
        } else {
            out.supersteps_replaced += step.supersteps;
            if (step.settled_bytes != 0) {
                auto const busiest = std::max_element(settled.begin(), settled.end());
                step.busiest = static_cast<std::uint32_t>(busiest - settled.begin());
                step.busiest_bytes = *busiest;
                auto const each = model.exchange_millicycles_a_byte;
                if (each != 0 && step.busiest_bytes > (most - 999) / each) refuse();
                step.bound_cycles =
                    model.exchange_cycles + model_detail::per_thousand(step.busiest_bytes, each) + model.sync_cycles;
                ++out.exchanges;
            }
        }
        if (step.bound_cycles > most - out.bound_cycles) refuse();
        out.news_cycles += step.news_cycles;
        out.bound_cycles += step.bound_cycles;
    }
    return out;
}

}} // namespace tilemesh
