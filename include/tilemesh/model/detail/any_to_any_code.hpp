#pragma once
#include <algorithm>
#include <limits>
#include <tilemesh/model/any_to_any.hpp>
#include <tilemesh/model/detail/trace_reading.hpp>

namespace tilemesh { inline namespace v0_2 {

TILEMESH_HOST AnyToAny any_to_any(CostModel const& model, Trace const& trace, Grid grid)
{
    model_detail::check_trace(trace, grid);
    AnyToAny out;
    auto const costs = step_costs(trace, model_cost(model, trace, grid));
    for (std::uint32_t i = 0; i < costs.size(); ++i) {
        auto const& s = costs[i];
        if (i == 0 || trace.kernels[i] != trace.kernels[i - 1]) {
            out.steps.emplace_back();
            out.steps.back().kernel = trace.kernels[i];
            out.steps.back().first = i;
        }
        auto& step = out.steps.back();
        step.last = i;
        step.supersteps += s.passes;
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
                step.bound_cycles = model.exchange_cycles + model_detail::per_thousand(step.busiest_bytes, each) + model.sync_cycles;
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
