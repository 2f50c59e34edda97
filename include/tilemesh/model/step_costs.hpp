#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/detail/trace_reading.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// A unique name for each step of a program: the name of its kernel. If several steps have one kernel, a number follows: "bloom 1", "bloom
/// 2". If a kernel itself has such a name, "bloom 1", every name begins with the step's place in the program.
inline std::vector<std::string> step_names(Trace const& trace)
{
    std::vector<std::string> names;
    for (std::size_t i = 0; i < trace.kernels.size(); ++i) {
        auto const& kernel = trace.kernels[i];
        auto const number = 1 + std::count(trace.kernels.begin(), trace.kernels.begin() + static_cast<std::ptrdiff_t>(i), kernel);
        bool const alone = std::count(trace.kernels.begin(), trace.kernels.end(), kernel) == 1;
        names.push_back(alone ? kernel : kernel + " " + std::to_string(number));
    }
    auto sorted = names;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
        for (std::size_t i = 0; i < names.size(); ++i) names[i] = "step " + std::to_string(i) + ": " + names[i];
    return names;
}

/// The counts of one step of a program (one Superstep, Repeat or UntilQuiet) in a run, and its modelled cycles. All are sums over its
/// passes.
struct StepCost {
    std::string name;                     ///< from step_names
    std::uint64_t passes = 0;             ///< runs of its kernel over the tiles that had to run
    std::uint64_t exchanges = 0;          ///< exchanges that carried a message or a note
    std::uint64_t tile_runs = 0, sent_bytes = 0;
    std::uint64_t compute = 0, exchange = 0, sync = 0, vote = 0; ///< cycles; 0 without a cost model
    std::uint64_t total() const noexcept { return compute + exchange + sync + vote; }
    friend bool operator==(StepCost const&, StepCost const&) = default;
};

/// One round of a Loop in a run, and its supersteps.
struct LoopRound {
    std::uint32_t loop;         ///< number in Trace::loops
    std::uint64_t number;       ///< among the rounds of that Loop in the run, from 1
    std::size_t first, last;    ///< its supersteps
    friend bool operator==(LoopRound const&, LoopRound const&) = default;
};

/// The rounds of each Loop of the run, in order: loop by loop, then by time. A trace has no marks between rounds. A round begins where the
/// steps of a Loop begin anew. If this does not give as many rounds as the run counted (a round without a superstep, a Loop of one
/// UntilQuiet), the Loop has no rounds here. Cost: linear in the trace, for each Loop.
inline std::vector<LoopRound> loop_rounds(Trace const& trace)
{
    std::vector<LoopRound> all;
    for (std::uint32_t l = 0; l < trace.loops.size(); ++l) {
        auto const has = [&](LoopCounters const& loop, std::uint32_t step) { return loop.first <= step && step <= loop.last; };
        auto const& own = trace.loops[l];
        // Does a Loop inside this one begin anew between these two steps?
        auto const inside = [&](std::uint32_t before, std::uint32_t step) {
            return std::any_of(trace.loops.begin() + static_cast<std::ptrdiff_t>(l) + 1, trace.loops.end(),
                               [&](LoopCounters const& other) { return has(own, other.first) && has(other, before) && has(other, step); });
        };
        std::uint64_t passes = 0;
        for (auto const& s : trace.supersteps) passes += has(own, s.step) ? 1 : 0;
        bool const each = own.first == own.last && passes == own.rounds; // every pass is a round
        std::vector<LoopRound> rounds;
        for (std::size_t i = 0; i < trace.supersteps.size(); ++i) {
            auto const step = trace.supersteps[i].step;
            if (!has(own, step)) continue;
            auto const before = i == 0 ? step : trace.supersteps[i - 1].step;
            if (i == 0 || !has(own, before) || each || (step < before && !inside(before, step)))
                rounds.push_back({l, rounds.size() + 1, i, i});
            rounds.back().last = i;
        }
        if (rounds.size() == own.rounds) all.insert(all.end(), rounds.begin(), rounds.end());
    }
    return all;
}

/// The counts of each step of the run, in program order, without cycles. A step that never ran has zeros. Throws `Error` if the trace runs
/// a step that it does not name. Cost: linear in the trace.
inline std::vector<StepCost> step_costs(Trace const& trace)
{
    std::vector<StepCost> steps;
    for (auto& name : step_names(trace)) steps.emplace_back().name = std::move(name);
    for (auto const& superstep : trace.supersteps) {
        if (superstep.step >= steps.size())
            throw Error("the passes of a run cannot be summed by step (one is of step " + std::to_string(superstep.step) +
                        " of a program of " + std::to_string(steps.size()) + "); give the trace of a run");
        auto& s = steps[superstep.step];
        ++s.passes;
        s.exchanges += superstep.sent ? 1 : 0;
        s.tile_runs += superstep.tiles.size();
        for (auto const& tile : superstep.tiles) s.sent_bytes += model_detail::all_sent(tile);
    }
    return steps;
}

/// The counts and the modelled cycles of each step of the run, in program order. `cost` must be the result of model_cost for this trace;
/// the totals add up to its cycles. Throws `Error` if `cost` is of another trace: another number of supersteps, or a superstep of another
/// step. Cost: linear in the trace.
inline std::vector<StepCost> step_costs(Trace const& trace, RunCost const& cost)
{
    bool same = trace.supersteps.size() == cost.supersteps.size();
    for (std::size_t i = 0; same && i < cost.supersteps.size(); ++i)
        same = cost.supersteps[i].step == trace.supersteps[i].step && cost.supersteps[i].step < trace.kernels.size();
    if (!same)
        throw Error("the costs of " + std::to_string(cost.supersteps.size()) + " supersteps cannot be summed by step (the trace has " +
                    std::to_string(trace.supersteps.size()) + ", or they are of other steps); apply the model to this trace");
    auto steps = step_costs(trace);
    for (auto const& c : cost.supersteps) {
        auto& s = steps[c.step];
        s.compute += c.compute;
        s.exchange += c.exchange;
        s.sync += c.sync;
        s.vote += c.vote;
    }
    return steps;
}

}} // namespace tilemesh
