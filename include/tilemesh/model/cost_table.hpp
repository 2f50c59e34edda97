#pragma once
#include <span>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/model/step_costs.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/report/table.hpp>

namespace tilemesh { inline namespace v0_2 {

/// The modelled milliseconds of `cycles` as text, with four decimals (0.1 microseconds).
inline std::string milliseconds_text(CostModel const& model, std::uint64_t cycles)
{
    return decimals(milliseconds(model, cycles), 4);
}

/// The ledger of a tile's SRAM (Layout::ledger()) as a table for terminals: bytes by region, then the sum of the bytes that count
/// against `sram_bytes`.
inline report::Table ledger_table(std::span<machine::Region const> ledger, std::uint32_t sram_bytes)
{
    report::Table table{{"region", "bytes of a tile"}};
    std::uint64_t sum = 0;
    for (auto const& region : ledger) {
        table.add_row({std::string(region.name.text, region.name.size), report::thousands(region.bytes)});
        sum += region.budgeted ? region.bytes : 0;
    }
    return table.add_row({"sum, of " + report::thousands(sram_bytes), report::thousands(sum)});
}

/// A run's modelled cost as a table for terminals: a row for each step of the program, then their sum. The columns are passes, exchanges
/// that carried something, cycles, and milliseconds at the model's clock. `cost` must be the result of model_cost for this trace; throws
/// `Error` if it is of another trace.
inline report::Table cost_table(CostModel const& model, Trace const& trace, RunCost const& cost)
{
    using report::thousands;
    report::Table table{{"step", "passes", "exchanges", "compute", "exchange", "sync and vote", "modelled ms"}};
    auto const add = [&](std::string const& name, StepCost const& s) {
        table.add_row({name, thousands(s.passes), thousands(s.exchanges), thousands(s.compute), thousands(s.exchange),
                       thousands(s.sync + s.vote), milliseconds_text(model, s.total())});
    };
    StepCost sum;
    for (auto const& s : step_costs(trace, cost)) {
        add(s.name, s);
        sum.passes += s.passes;
        sum.exchanges += s.exchanges;
        sum.compute += s.compute;
        sum.exchange += s.exchange;
        sum.sync += s.sync;
        sum.vote += s.vote;
    }
    add("sum", sum);
    return table;
}

}} // namespace tilemesh
