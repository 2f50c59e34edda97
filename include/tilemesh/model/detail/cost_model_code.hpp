#pragma once
#include <algorithm>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/detail/trace_reading.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

TILEMESH_HOST PriceKind kind_of_source(std::string_view source) noexcept
{
    if (source.find("guess") != source.npos) return PriceKind::guessed;
    constexpr std::pair<std::string_view, PriceKind> words[] = {{"document", PriceKind::documented}, {"measured", PriceKind::measured},
                                                                {"arithmetic", PriceKind::counted},  {"counted", PriceKind::counted},
                                                                {"fitted", PriceKind::fitted}};
    for (auto const& [word, kind] : words)
        if (source.substr(0, word.size()) == word) return kind;
    return PriceKind::guessed;
}

namespace model_detail {

TILEMESH_HOST void expect_sums_fit(CostModel const& m)
{
    std::uint64_t millicycles = m.exchange_millicycles_a_byte, cycles = 0;
    for (auto const& p : m.prices) millicycles = std::max(millicycles, p.millicycles);
    for (auto n : {m.run_cycles, m.exchange_cycles, m.sync_cycles, m.vote_cycles}) cycles = std::max(cycles, n);
    if (millicycles > most_millicycles || cycles > most_cycles)
        throw Error("a cost model cannot be applied (" +
                    (millicycles > most_millicycles ? std::to_string(millicycles) + " millicycles exceed " + std::to_string(most_millicycles)
                                                    : std::to_string(cycles) + " cycles exceed " + std::to_string(most_cycles)) +
                    "); give it smaller numbers");
}

TILEMESH_HOST OperationPrice const* find_price(CostModel const& m, std::string_view operation) noexcept
{
    auto const p = std::find_if(m.prices.begin(), m.prices.end(), [&](OperationPrice const& known) { return known.operation == operation; });
    return p == m.prices.end() ? nullptr : &*p;
}

TILEMESH_HOST StepPrices::StepPrices(CostModel const& model, Trace const& trace) : model_(model), trace_(trace)
{
    for (std::size_t step = 0; step < trace.kernels.size(); ++step) {
        auto& of_step = millicycles_.emplace_back();
        of_step.fill(none);
        auto const& names = operations_of_step(trace, step);
        for (std::size_t kind = 0; kind < names.size() && kind < of_step.size(); ++kind)
            if (auto const* p = find_price(model, names[kind])) of_step[kind] = p->millicycles;
    }
}

TILEMESH_HOST std::uint64_t StepPrices::compute_cycles(std::size_t superstep, OperationCounts const& o) const
{
    auto const& of_step = millicycles_[trace_.supersteps[superstep].step];
    std::uint64_t millicycles = 0;
    for (std::uint32_t kind = 0; kind < most_operation_kinds; ++kind) {
        if (o[kind] == 0) continue;
        if (of_step[kind] == none) refuse(superstep, kind);
        millicycles += o[kind] * of_step[kind];
    }
    return model_.run_cycles + (millicycles + 999) / 1000;
}

TILEMESH_HOST void StepPrices::refuse(std::size_t superstep, std::uint32_t kind) const
{
    auto const step = trace_.supersteps[superstep].step;
    auto const& names = operations_of_step(trace_, step);
    throw Error("cost model \"" + model_.name + "\" cannot be applied (operation " +
                (kind < names.size() ? names[kind] : "number " + std::to_string(kind) + ", which has no name,") + " of kernel " +
                trace_.kernels[step] + " occurs, first in superstep " + std::to_string(superstep) +
                ", and has no price); give it one (set_price, or a line of the model's file), and say where it is from");
}

} // namespace model_detail

TILEMESH_HOST std::uint64_t price_of(CostModel const& model, std::string_view operation)
{
    auto const* const p = model_detail::find_price(model, operation);
    if (p == nullptr) {
        std::string all;
        for (auto const& known : model.prices) all += (all.empty() ? "" : ", ") + known.operation;
        throw Error("cost model \"" + model.name + "\" has no price for operation " + std::string(operation) + " (it prices " +
                    (all.empty() ? "none" : all) + "); give it one (set_price, or a line of the model's file)");
    }
    return p->millicycles;
}

TILEMESH_HOST RunCost model_cost(CostModel const& m, Trace const& trace, Grid grid)
{
    model_detail::expect_sums_fit(m);
    RunCost out;
    out.busy.assign(trace.kernels.size(), std::vector<std::uint64_t>(grid.size(), 0));
    std::vector<std::uint64_t> received(grid.size());
    model_detail::StepPrices const prices(m, trace);
    model_detail::Crossings crossings(m.chips, grid);
    model_detail::NetworkPrices network(m, grid);
    for (std::size_t i = 0; i < trace.supersteps.size(); ++i) {
        auto const& s = trace.supersteps[i];
        SuperstepCost c{s.step};
        for (auto const& t : s.tiles) {
            auto const cycles = prices.compute_cycles(i, t.operations);
            out.busy[s.step][t.tile] += cycles;
            if (cycles > c.compute) {
                c.compute = cycles;
                c.slowest = t.tile;
            }
        }
        std::uint64_t bytes = 0; // that the busiest tile receives
        std::uint32_t busiest = 0;
        bool const exchanges = m.exchange_cost == ExchangeCost::capacity ? s.capacity_bytes != 0 : s.sent;
        if (exchanges && m.network) {
            auto const time = network.of(s);
            c.exchange = m.exchange_cycles + time.drained;
            c.bound = time.bound;
        } else if (exchanges) {
            if (m.exchange_cost == ExchangeCost::capacity) {
                bytes = s.capacity_of_tile();
                c.crossing_bytes = crossings.of_capacity(s);
            } else {
                std::fill(received.begin(), received.end(), 0);
                for (auto const& t : s.tiles)
                    for (Direction d : news) received[grid.index_of(grid.neighbour(grid.tile(t.tile), d, s.edge))] += t.sent_bytes[index(d)];
                auto const most = std::max_element(received.begin(), received.end());
                bytes = *most;
                busiest = static_cast<std::uint32_t>(most - received.begin());
                c.crossing_bytes = crossings.of_messages(s);
            }
            auto const on_chip = model_detail::per_thousand(bytes, m.exchange_millicycles_a_byte);
            auto const at_border = crossings.cycles(c.crossing_bytes);
            c.crossing = at_border > on_chip ? at_border - on_chip : 0;
            c.exchange = m.exchange_cycles + on_chip + c.crossing;
            auto const tile = grid.tile(busiest);
            if (c.crossing != 0) c.bound = crossings.busiest();
            else if (on_chip != 0) c.bound = {NetworkResource::port_in, {tile.x(), tile.y()}, ' '};
        }
        c.sync = m.sync_cycles;
        c.vote = s.votes ? m.vote_cycles : 0;
        if (c.total() > std::numeric_limits<std::uint64_t>::max() - out.cycles)
            throw Error("a run cannot be modelled (its cycles pass 64 bits after " + std::to_string(out.supersteps.size()) +
                        " supersteps); give the cost model smaller numbers");
        out.cycles += c.total();
        out.supersteps.push_back(c);
    }
    return out;
}

TILEMESH_HOST double milliseconds(CostModel const& m, std::uint64_t cycles) noexcept
{
    return static_cast<double>(cycles) / static_cast<double>(m.clock_khz);
}

}} // namespace tilemesh

#include <tilemesh/model/exchange.hpp> // the code of NetworkPrices, which needs a whole CostModel
