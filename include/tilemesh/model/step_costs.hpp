#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// Modelled cycles of one step of a program (one Superstep, Repeat or UntilQuiet): the sums over its supersteps.
struct StepCost {
    std::string kernel;
    std::uint64_t supersteps = 0; ///< compute phases, whether or not an exchange followed
    std::uint64_t compute = 0, exchange = 0, sync = 0, vote = 0;
    std::uint64_t total() const noexcept { return compute + exchange + sync + vote; }
    friend bool operator==(StepCost const&, StepCost const&) = default;
};

/// What each step of the run cost, in program order; a step that never ran costs nothing. `cost` is what model_cost made of this
/// trace, and the totals add up to its cycles. Throws `Error` where it is of another trace: another number of supersteps, or a
/// superstep of another step. Cost: linear in the supersteps.
inline std::vector<StepCost> step_costs(Trace const& trace, RunCost const& cost)
{
    std::vector<StepCost> steps(trace.kernels.size());
    for (std::size_t i = 0; i < steps.size(); ++i) steps[i].kernel = trace.kernels[i];
    bool same = trace.supersteps.size() == cost.supersteps.size();
    for (std::size_t i = 0; same && i < cost.supersteps.size(); ++i) {
        auto const& c = cost.supersteps[i];
        same = c.step == trace.supersteps[i].step && c.step < steps.size();
        if (!same) break;
        auto& s = steps[c.step];
        ++s.supersteps;
        s.compute += c.compute;
        s.exchange += c.exchange;
        s.sync += c.sync;
        s.vote += c.vote;
    }
    if (!same)
        throw Error("the costs of " + std::to_string(cost.supersteps.size()) + " supersteps cannot be summed by step (the trace has " +
                    std::to_string(trace.supersteps.size()) + ", or they are of other steps); apply the model to this trace");
    return steps;
}

}} // namespace tilemesh
