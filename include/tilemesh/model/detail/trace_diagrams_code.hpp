#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <tilemesh/model/cost_table.hpp>
#include <tilemesh/model/trace_diagrams.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/table.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

TILEMESH_HOST std::string steps_svg(CostModel const& model, std::vector<StepCost> const& steps)
{
    report::StackedBars chart;
    chart.title = "Where the time goes, by step";
    chart.x_label = "modelled milliseconds";
    chart.parts = {{"compute", 4}, {"exchange", 1}, {"sync", 3}, {"vote", 6}};
    chart.width = 1200;
    std::uint64_t all = 0;
    for (auto const& s : steps) all += s.total();
    for (auto const& s : steps) {
        report::Bar bar{s.name, {}};
        for (auto const cycles : {s.compute, s.exchange, s.sync, s.vote}) bar.values.push_back(milliseconds(model, cycles));
        bar.note = milliseconds_text(model, s.total()) + " ms, " + report::share_text(static_cast<double>(s.total()), static_cast<double>(all));
        chart.bars.push_back(std::move(bar));
    }
    return svg(chart);
}

TILEMESH_HOST std::vector<report::BarSpan> step_spans(Trace const& trace, CostModel const& model, RunCost const& cost)
{
    constexpr std::size_t most_spans = 40;
    auto const names = step_names(trace);
    // One span for all supersteps in a row that have one number.
    auto const with = [&](auto const& number_of, auto const& name_of_number) {
        std::vector<report::BarSpan> spans;
        std::optional<std::size_t> last;
        for (std::size_t i = 0; i < cost.supersteps.size(); ++i) {
            std::size_t const number = number_of(i);
            if (last != number) spans.push_back({name_of_number(number, i), 0});
            last = number;
            spans.back().width += milliseconds(model, cost.supersteps[i].total());
        }
        return spans;
    };
    auto const step_of = [&](std::size_t i) -> std::size_t { return cost.supersteps[i].step; };
    auto spans = with(step_of, [&](std::size_t step, std::size_t) { return names[step]; });
    if (spans.size() <= most_spans || trace.loops.empty()) return spans;

    auto const loop_of = [&](std::size_t i) -> std::size_t { // an outer loop comes before its inner loops
        std::size_t l = 0;
        while (l < trace.loops.size() && (step_of(i) < trace.loops[l].first || step_of(i) > trace.loops[l].last)) ++l;
        return l;
    };
    std::vector<LoopRound> const rounds = loop_rounds(trace);
    std::vector<LoopRound const*> round_of(cost.supersteps.size(), nullptr); // of each superstep, in its outermost Loop
    for (auto const& round : rounds)
        for (auto i = round.first; i <= round.last; ++i)
            if (loop_of(i) == round.loop) round_of[i] = &round;
    auto const text = [](std::uint64_t n, char const* what) { return report::thousands(n) + " " + what + (n == 1 ? "" : "s"); };
    spans = with(
        [&](std::size_t i) { return round_of[i] != nullptr ? names.size() + static_cast<std::size_t>(round_of[i] - rounds.data()) : step_of(i); },
        [&](std::size_t number, std::size_t i) {
            return round_of[i] != nullptr ? "round " + report::thousands(round_of[i]->number) : names[number];
        });
    auto together = with([&](std::size_t i) { return loop_of(i) < trace.loops.size() ? names.size() + loop_of(i) : step_of(i); },
                [&](std::size_t number, std::size_t i) {
                    if (number < names.size()) return names[number];
                    auto const& loop = trace.loops[number - names.size()];
                    auto count = loop.rounds;
                    if (round_of[i] != nullptr) { // a run of several parts comes to a Loop several times
                        auto last = i;
                        while (last + 1 < cost.supersteps.size() && loop_of(last + 1) == loop_of(i)) ++last;
                        count = round_of[last]->number - round_of[i]->number + 1;
                    }
                    std::string name = text(count, "round") + " of ";
                    for (auto step = loop.first; step <= loop.last && step < names.size(); ++step)
                        name += (step == loop.first ? "" : ", ") + names[step];
                    return name;
                });
    return spans.size() <= most_spans && spans.size() > together.size() ? spans : together;
}

TILEMESH_HOST std::string supersteps_svg(Trace const& trace, CostModel const& model, RunCost const& cost, Grid grid)
{
    constexpr double most_bars = 400; // fewer bars than the diagram has pixels
    report::StackedBars chart;
    chart.title = "The run over time: which step runs, and what the tiles do";
    chart.x_label = "modelled milliseconds";
    chart.y_label = "percent of tile time";
    chart.parts = {{"busy", 4}, {"idle", 7}, {"exchange", 1}, {"sync", 3}, {"vote", 6}};
    chart.layout = report::BarLayout::along_x;
    chart.y_high = 100;
    chart.width = 1200;
    chart.spans = step_spans(trace, model, cost);
    std::array<double, 5> cycles{};
    double sum = 0;
    auto const draw = [&] {
        if (sum == 0) return;
        report::Bar bar;
        for (double const c : cycles) bar.values.push_back(100 * c / sum);
        bar.width = sum / static_cast<double>(model.clock_khz);
        chart.bars.push_back(std::move(bar));
        cycles = {};
        sum = 0;
    };
    model_detail::StepPrices const prices(model, trace);
    for (std::size_t i = 0; i < cost.supersteps.size(); ++i) {
        auto const& c = cost.supersteps[i];
        std::uint64_t all_busy = 0;
        for (auto const& t : trace.supersteps[i].tiles) all_busy += prices.compute_cycles(i, t.operations);
        double const busy = static_cast<double>(all_busy) / grid.size();
        std::array<double, 5> const more = {busy, std::max(static_cast<double>(c.compute) - busy, 0.0), static_cast<double>(c.exchange),
                                            static_cast<double>(c.sync), static_cast<double>(c.vote)};
        for (std::size_t k = 0; k < more.size(); ++k) {
            cycles[k] += more[k];
            sum += more[k];
        }
        if (sum * most_bars >= static_cast<double>(cost.cycles)) draw();
    }
    draw();
    return svg(chart);
}

}} // namespace tilemesh
