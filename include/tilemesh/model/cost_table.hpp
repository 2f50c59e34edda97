#pragma once
#include <array>
#include <charconv>
#include <string>
#include <tilemesh/model/step_costs.hpp>
#include <tilemesh/report/table.hpp>
#include <vector>

namespace tilemesh {

/// Modelled milliseconds of these cycles as text: four decimals, a tenth of a microsecond.
inline std::string milliseconds_text(CostModel const& model, std::uint64_t cycles)
{
    std::array<char, 64> text{}; // 2^64 cycles at 1 kHz have 20 digits before the point
    auto const end = std::to_chars(text.data(), text.data() + text.size(), milliseconds(model, cycles), std::chars_format::fixed, 4);
    return {text.data(), end.ptr};
}

/// A run's modelled cost as a table for terminals: a row for each step of the program, then their sum. Cycles, and milliseconds at
/// the model's clock. `cost` is what model_cost made of this trace; throws `Error` where it is of another.
inline report::Table cost_table(CostModel const& model, Trace const& trace, RunCost const& cost)
{
    using report::thousands;
    report::Table table{{"step", "supersteps", "compute", "exchange", "sync and vote", "modelled ms"}};
    auto const add = [&](std::string const& name, StepCost const& s) {
        table.add_row({name, thousands(s.supersteps), thousands(s.compute), thousands(s.exchange), thousands(s.sync + s.vote),
                       milliseconds_text(model, s.total())});
    };
    StepCost sum;
    for (auto const& s : step_costs(trace, cost)) {
        add(s.kernel, s);
        sum.supersteps += s.supersteps;
        sum.compute += s.compute;
        sum.exchange += s.exchange;
        sum.sync += s.sync;
        sum.vote += s.vote;
    }
    add("sum", sum);
    return table;
}

} // namespace tilemesh
