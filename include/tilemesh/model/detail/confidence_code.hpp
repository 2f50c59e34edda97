#pragma once
#include <algorithm>
#include <cstddef>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/model/confidence.hpp>
#include <tilemesh/model/detail/trace_reading.hpp>
#include <tilemesh/report/number_text.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

TILEMESH_HOST PriceKind kind_of_network(Network const& n) noexcept
{
    auto weakest = PriceKind::documented;
    for (auto const* number : {&n.link, &n.port_in, &n.port_out, &n.memory, &n.flit, &n.packet, &n.head, &n.hop, &n.latency, &n.issue, &n.outstanding,
                               &n.border, &n.crossing})
        if (number->value != 0) weakest = std::max(weakest, kind_of_source(number->source));
    return weakest;
}

TILEMESH_HOST Confidence confidence_of(CostModel const& model, Trace const& trace, RunCost const& cost)
{
    if (cost.supersteps.size() != trace.supersteps.size())
        throw Error("what a run's cycles rest on cannot be said (its cost has " + std::to_string(cost.supersteps.size()) + " supersteps, its trace " +
                    std::to_string(trace.supersteps.size()) + "); model this trace");
    std::vector<std::pair<std::string, std::uint64_t>> cycles; // by price
    auto const add = [&](std::string_view name, std::uint64_t n) {
        auto const at = std::find_if(cycles.begin(), cycles.end(), [&](auto const& known) { return known.first == name; });
        if (at != cycles.end()) at->second += n;
        else if (n != 0) cycles.emplace_back(name, n);
    };
    for (std::size_t i = 0; i < trace.supersteps.size(); ++i) {
        auto const& s = trace.supersteps[i];
        auto const& c = cost.supersteps[i];
        auto const slowest = std::find_if(s.tiles.begin(), s.tiles.end(), [&](TileSample const& t) { return t.tile == c.slowest; });
        std::uint64_t counted = 0;
        if (c.compute != 0 && slowest != s.tiles.end()) {
            auto const& names = model_detail::operations_of_step(trace, s.step);
            for (std::size_t kind = 0; kind < names.size() && kind < most_operation_kinds; ++kind) {
                std::uint64_t const n = slowest->operations[static_cast<std::uint32_t>(kind)];
                if (n == 0) continue;
                auto const whole = n * price_of(model, names[kind]) / 1000;
                counted += whole;
                add(names[kind], whole);
            }
        }
        add("run", c.compute - std::min(c.compute, counted));
        std::uint64_t const fixed = std::min(c.exchange - c.crossing, model.exchange_cycles);
        add("exchange", fixed);
        add(model.network ? "network" : "exchange_byte", c.exchange - c.crossing - fixed);
        add("borders between chips", c.crossing);
        add("sync", c.sync);
        add("vote", c.vote);
    }
    std::stable_sort(cycles.begin(), cycles.end(), [](auto const& a, auto const& b) { return a.second > b.second; });
    Confidence out;
    auto const kind_of = [&](std::string const& name) {
        if (model.network && name == "network") return kind_of_network(*model.network);
        auto const p =
            std::find_if(model.parameters.begin(), model.parameters.end(), [&](ModelParameter const& known) { return known.name == name; });
        return p == model.parameters.end() ? PriceKind::guessed : p->kind;
    };
    for (auto const& [name, n] : cycles) {
        auto const kind = kind_of(name);
        out.cycles[static_cast<std::size_t>(kind)] += n;
        if (kind > out.weakest) {
            out.weakest = kind;
            out.names.clear();
        }
        if (kind == out.weakest) out.names.push_back(name);
    }
    return out;
}

TILEMESH_HOST std::string confidence_text(CostModel const& model, Trace const& trace, RunCost const& cost)
{
    auto const c = confidence_of(model, trace, cost);
    if (c.names.empty()) return {};
    std::string text = "The weakest prices behind this time are " + std::string(price_kind_names[static_cast<std::size_t>(c.weakest)]) + ":";
    for (auto const& name : c.names) text += (&name == c.names.data() ? " " : ", ") + name;
    return text + ". They make " +
           report::share_text(static_cast<double>(c.cycles[static_cast<std::size_t>(c.weakest)]), static_cast<double>(cost.cycles)) +
           " of its cycles.";
}

}} // namespace tilemesh
