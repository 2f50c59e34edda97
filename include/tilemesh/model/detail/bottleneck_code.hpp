#pragma once
#include <algorithm>
#include <cstddef>
#include <numeric>
#include <tilemesh/model/bottleneck.hpp>
#include <tilemesh/model/detail/trace_reading.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/table.hpp>

namespace tilemesh { inline namespace v0_2 {

TILEMESH_HOST std::optional<SlowestTile> slowest_tile(CostModel const& model, Trace const& trace, RunCost const& cost, Grid grid, std::uint32_t step)
{
    std::vector<std::uint64_t> as_slowest(grid.size(), 0);
    for (auto const& c : cost.supersteps)
        if (c.step == step && c.compute != 0) as_slowest[c.slowest] += c.compute;
    auto const most = std::max_element(as_slowest.begin(), as_slowest.end());
    if (most == as_slowest.end() || *most == 0) return {};
    SlowestTile out;
    out.tile = static_cast<std::uint32_t>(most - as_slowest.begin());
    out.cycles = *most;
    for (auto const& name : model_detail::operations_of_step(trace, step)) out.operations.push_back({name});
    for (std::size_t i = 0; i < trace.supersteps.size(); ++i) {
        auto const& c = cost.supersteps[i];
        if (c.step != step || c.compute == 0 || c.slowest != out.tile) continue;
        ++out.passes;
        for (auto const& t : trace.supersteps[i].tiles)
            for (std::size_t kind = 0; t.tile == out.tile && kind < out.operations.size(); ++kind) {
                auto& counted = out.operations[kind];
                if (t.operations.count[kind] == 0) continue;
                counted.count += t.operations.count[kind];
                counted.cycles += static_cast<double>(t.operations.count[kind]) * static_cast<double>(price_of(model, counted.operation)) / 1000;
            }
    }
    std::erase_if(out.operations, [](SlowestTile::Counted const& counted) { return counted.count == 0; });
    std::stable_sort(out.operations.begin(), out.operations.end(),
                     [](SlowestTile::Counted const& a, SlowestTile::Counted const& b) { return a.cycles > b.cycles; });
    return out;
}

TILEMESH_HOST std::optional<Bottleneck> find_bottleneck(CostModel const& model, Trace const& trace, RunCost const& cost, Grid grid)
{
    auto const steps = step_costs(trace, cost);
    Bottleneck out;
    for (auto const phase : {Bottleneck::Phase::compute, Bottleneck::Phase::exchange, Bottleneck::Phase::sync})
        for (std::uint32_t i = 0; i < steps.size(); ++i) {
            auto const& s = steps[i];
            auto const cycles = phase == Bottleneck::Phase::compute ? s.compute : phase == Bottleneck::Phase::exchange ? s.exchange : s.sync + s.vote;
            if (cycles > out.cycles) out.phase = phase, out.step = i, out.cycles = cycles, out.passes = s.passes;
        }
    if (out.cycles == 0) return {};
    if (out.phase != Bottleneck::Phase::compute) return out;

    auto const slowest = slowest_tile(model, trace, cost, grid, out.step).value(); // there is one: the step has compute
    out.tile = slowest.tile;
    out.tile_passes = slowest.passes;
    out.tile_cycles = slowest.cycles;
    auto const& busy = cost.busy[out.step];
    out.mean_cycles = std::accumulate(busy.begin(), busy.end(), 0.0) / grid.size();
    out.operation_cycles = static_cast<double>(model.run_cycles) * static_cast<double>(out.tile_passes);
    if (!slowest.operations.empty() && slowest.operations[0].cycles > out.operation_cycles) {
        out.operation = slowest.operations[0].operation;
        out.operation_cycles = slowest.operations[0].cycles;
    }
    return out;
}

namespace model_detail {

TILEMESH_HOST std::string tile_text(Grid grid, std::uint32_t tile)
{
    return "(" + std::to_string(grid.tile(tile).x()) + ", " + std::to_string(grid.tile(tile).y()) + ")";
}

TILEMESH_HOST std::string passes_text(std::uint64_t passes)
{
    return report::thousands(passes) + (passes == 1 ? " pass" : " passes");
}

TILEMESH_HOST std::string exchanges_text(std::uint64_t exchanges)
{
    return report::thousands(exchanges) + (exchanges == 1 ? " exchange" : " exchanges");
}

} // namespace model_detail

TILEMESH_HOST std::string bottleneck_text(std::optional<Bottleneck> const& bottleneck, CostModel const& model, Trace const& trace,
                                          RunCost const& cost, Grid grid, std::string_view run, std::string_view because)
{
    using namespace model_detail;
    using report::share_text;
    auto const whole = static_cast<double>(cost.cycles);
    if (!bottleneck) return "The " + std::string(run) + " took no modelled time: " + passes_text(cost.supersteps.size()) + ".";
    auto const& b = *bottleneck;
    auto const step = "step " + step_names(trace)[b.step];
    auto const of_run = share_text(static_cast<double>(b.cycles), whole) + " of the " + std::string(run) + " is ";
    if (b.phase == Bottleneck::Phase::sync)
        return "Slowest: the synchronisation of " + step + "; " + of_run + "waiting for all tiles after each of its " + passes_text(b.passes) + ".";
    if (b.phase == Bottleneck::Phase::exchange) {
        std::uint64_t capacity = 0, fullest = 0, sent = 0, paid = 0;
        for (std::size_t i = 0; i < trace.supersteps.size(); ++i) {
            auto const& s = trace.supersteps[i];
            if (s.step != b.step || cost.supersteps[i].exchange == 0) continue;
            ++paid;
            for (Direction d : news) capacity = std::max<std::uint64_t>(capacity, s.capacity_towards(d));
            for (auto const& t : s.tiles) {
                sent += all_sent(t);
                for (auto const bytes : t.sent_bytes) fullest = std::max<std::uint64_t>(fullest, bytes);
            }
        }
        auto const text = "Slowest: the exchange of " + step + "; " + of_run;
        if (model.exchange_cost == ExchangeCost::live)
            return text + "its " + exchanges_text(paid) + ", which move " + report::thousands(sent) + " bytes in all.";
        return text + "moving the whole capacity of its channels after each of " + passes_text(paid) + ", " + report::thousands(capacity) +
               " bytes to each side of a tile, of which no side used more than " + report::thousands(fullest) + ".";
    }
    double const ratio = static_cast<double>(b.cycles) / b.mean_cycles;
    bool const even = ratio < 1.1; // then no tile stands out
    bool const alone = b.tile_cycles == b.cycles && !even;
    auto const tile = "tile " + tile_text(grid, b.tile);
    auto text = "Slowest: " + (alone ? tile : step) + "; " + of_run + "its compute" + (alone ? " in " + step : "") +
                (even ? ", which the tiles share evenly" : ", " + report::decimals(ratio, 1) + " times the mean of all tiles");
    if (!even && !alone)
        text += ", and for " + share_text(static_cast<double>(b.tile_cycles), static_cast<double>(b.cycles)) + " of that time (" +
                report::thousands(b.tile_passes) + " of " + passes_text(b.passes) + ") all tiles wait for " + tile;
    if (!even && !because.empty()) text += ", because " + std::string(because);
    auto const share = share_text(b.operation_cycles, static_cast<double>(b.tile_cycles));
    if (b.operation_cycles > 0)
        text += "; " + share + " of " + (alone || even ? "that" : "the tile's") + " compute is " +
                (b.operation.empty() ? std::string("starting the kernel") : "operation " + b.operation);
    return text + ".";
}

TILEMESH_HOST std::string load_text(Trace const& trace, Grid grid, std::string_view run)
{
    using namespace model_detail;
    check_trace(trace, grid);
    std::uint64_t exchanges = 0, sent_bytes = 0, all_runs = 0;
    std::vector<std::uint64_t> sent(grid.size(), 0), runs(grid.size(), 0);
    for (auto const& s : trace.supersteps) {
        exchanges += s.sent ? 1 : 0;
        for (auto const& t : s.tiles) {
            auto const bytes = all_sent(t);
            sent[t.tile] += bytes, sent_bytes += bytes;
            ++runs[t.tile], ++all_runs;
        }
    }
    auto const text = "The " + std::string(run) + " took " + passes_text(trace.supersteps.size()) + " and " + exchanges_text(exchanges);
    if (all_runs == 0) return text + ".";
    auto const& load = sent_bytes != 0 ? sent : runs;
    auto const most = std::max_element(load.begin(), load.end());
    double const mean = static_cast<double>(sent_bytes != 0 ? sent_bytes : all_runs) / grid.size();
    return text + "; the most loaded tile is " + tile_text(grid, static_cast<std::uint32_t>(most - load.begin())) + ", which " +
           (sent_bytes != 0 ? "sent " + report::thousands(*most) + " bytes" : "ran " + report::thousands(*most) + (*most == 1 ? " time" : " times")) +
           ", " + report::decimals(static_cast<double>(*most) / mean, 1) + " times the mean.";
}

}} // namespace tilemesh
