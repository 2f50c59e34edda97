#pragma once
#include <algorithm>
#include <tilemesh/model/detail/trace_reading.hpp>
#include <tilemesh/model/step_costs.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

TILEMESH_HOST std::vector<std::string> step_names(Trace const& trace)
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

TILEMESH_HOST std::vector<LoopRound> loop_rounds(Trace const& trace)
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
            if (i == 0 || !has(own, before) || each || (step < before && !inside(before, step))) rounds.push_back({l, rounds.size() + 1, i, i});
            rounds.back().last = i;
        }
        if (rounds.size() == own.rounds) all.insert(all.end(), rounds.begin(), rounds.end());
    }
    return all;
}

TILEMESH_HOST std::vector<StepCost> step_costs(Trace const& trace)
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

TILEMESH_HOST std::vector<StepCost> step_costs(Trace const& trace, RunCost const& cost)
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
