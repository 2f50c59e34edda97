#pragma once
#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/any_to_any.hpp>
#include <tilemesh/model/cost_table.hpp>
#include <tilemesh/model/energy.hpp>
#include <tilemesh/model/step_costs.hpp>
#include <tilemesh/model/trace_files.hpp>
#include <tilemesh/report/heat_image.hpp>
#include <tilemesh/report/html.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/stacked_bars.hpp>
#include <utility>
#include <vector>

/// The parts of a page about a run: diagrams, tables and maps of the grid, from a trace of any program. trace_page.hpp makes the page.
namespace tilemesh { inline namespace v0_2 {

/// A number for each tile, which the page shows as a map of the grid.
struct TileMap {
    std::string name;           ///< of a file and a column: letters and `_`
    std::string title, what;    ///< the heading, and a phrase that says what the numbers are
    bool in_total = true;       ///< the sum over all tiles has a meaning
    std::vector<double> values; ///< one per tile, finite, not below 0
};

/// The maps that every trace has: how full its fullest channel end was, cycles that a tile computes, and cycles that it waits.
inline std::vector<TileMap> trace_maps(Trace const& trace, CostModel const& model, Grid grid)
{
    auto fill = heat_map(trace, model, grid, TileSum::channel_fill);
    for (auto& share : fill) share *= 100;
    return {{"channel_fill", "Channel fill", "percent of the fullest end of a channel in the fullest superstep", false, std::move(fill)},
            {"busy_cycles", "Busy cycles", "modelled cycles that the tile computes", true, heat_map(trace, model, grid, TileSum::busy_cycles)},
            {"idle_cycles", "Idle cycles", "modelled cycles that the tile waits for the slowest tile's compute", true,
             heat_map(trace, model, grid, TileSum::idle_cycles)}};
}

/// The map as a picture whose longer side has at most 480 pixels, but at least one pixel a tile: from dark blue for 0 over green to
/// yellow for the most that a tile has.
inline report::Image map_image(TileMap const& map, Grid grid)
{
    auto const cell = std::clamp(480 / std::max({grid.width, grid.height, 1u}), 1u, 16u);
    return report::heat_image(map.values, grid.width, grid.height, {0, report::finite_range(map.values).most}, cell);
}
/// The caption of a map: what it shows, the largest value of a tile, and the sum if that has a meaning. `shown` turns a number into text.
inline std::string map_caption(TileMap const& map, std::string (*shown)(double) = report::short_number)
{
    auto caption = map.title + ": " + map.what + ". 0 to " + shown(report::finite_range(map.values).most) + " a tile";
    if (map.in_total) caption += ", " + shown(std::accumulate(map.values.begin(), map.values.end(), 0.0)) + " in all";
    return caption + ".";
}
/// One line a tile, with the numbers of all maps; each map must have a value for every tile of the grid.
inline std::string maps_csv(std::span<TileMap const> maps, Grid grid)
{
    std::string text = "tile_x,tile_y";
    for (auto const& map : maps) text.append(",").append(map.name);
    text += '\n';
    for (std::uint32_t t = 0; t < grid.size(); ++t) {
        text += std::to_string(grid.tile(t).x()) + "," + std::to_string(grid.tile(t).y());
        for (auto const& map : maps) text.append(",").append(report::plain_number(map.values[t]));
        text += '\n';
    }
    return text;
}
/// One line a tile, with all digits of its joules.
inline std::string energy_csv(Energy const& energy, Grid grid)
{
    std::string text = "tile_x,tile_y,joules\n";
    std::array<char, 32> digits{}; // room for the shortest text that reads back as the same double: at most 24 characters
    for (std::uint32_t t = 0; t < grid.size(); ++t) {
        auto const end = std::to_chars(digits.data(), digits.data() + digits.size(), energy.joules_of_tile[t]);
        text += std::to_string(grid.tile(t).x()) + "," + std::to_string(grid.tile(t).y()) + ",";
        text.append(digits.data(), end.ptr) += '\n';
    }
    return text;
}

/// Where the cycles go: a bar for each step of the program, in milliseconds, as SVG.
inline std::string steps_svg(CostModel const& model, std::vector<StepCost> const& steps)
{
    report::StackedBars chart;
    chart.title = "Where the cycles go, by step";
    chart.x_label = "step of the program";
    chart.y_label = "modelled milliseconds";
    chart.parts = {{"compute", 4}, {"exchange", 1}, {"sync", 3}, {"vote", 6}};
    chart.width = 900;
    for (auto const& s : steps) {
        report::Bar bar{s.kernel, {}};
        for (auto const cycles : {s.compute, s.exchange, s.sync, s.vote}) bar.values.push_back(milliseconds(model, cycles));
        chart.bars.push_back(std::move(bar));
    }
    return svg(chart);
}

/// Supersteps over modelled time as SVG: how many tiles are busy. An area is tile time. Supersteps that are too thin to be seen share a
/// bar with their neighbours, so that there are about 400 bars. Cost: one pass over the trace; no memory per tile.
inline std::string supersteps_svg(Trace const& trace, CostModel const& model, RunCost const& cost, Grid grid)
{
    constexpr double most_bars = 400; // fewer bars than the diagram has pixels
    report::StackedBars chart;
    chart.title = "Supersteps over time: what the tiles do";
    chart.x_label = "modelled milliseconds";
    chart.y_label = "percent of tile time";
    chart.parts = {{"busy", 4}, {"idle", 7}, {"exchange", 1}, {"sync", 3}, {"vote", 6}};
    chart.layout = report::BarLayout::along_x;
    chart.y_high = 100;
    chart.width = 1200;
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

/// The contents of a page about a run: diagrams as SVG, tables as rows of text. About 100 KB, and the maps.
struct TraceSection {
    std::vector<std::pair<std::string, std::string>> maps; ///< a caption and a PNG for each map that the caller adds
    std::string steps_svg, supersteps_svg;
    std::vector<std::vector<std::string>> steps, ideal, energy_kinds, energy_steps; ///< the tables of energy may be empty
    std::size_t bytes() const noexcept
    {
        std::size_t pictures = 0;
        for (auto const& [what, png] : maps) pictures += png.size();
        return pictures / 3 * 4 + steps_svg.size() + supersteps_svg.size();
    }
};

/// The contents of a page about this run; the caller adds the maps. `cost` is the result of model_cost for this trace, `energy` that of
/// energy_of with `energy_model`. If both pointers are null, the page has no energy. Throws `Error` as step_costs and any_to_any do.
inline TraceSection trace_section(Trace const& trace, CostModel const& model, RunCost const& cost, Grid grid,
                                  EnergyModel const* energy_model = nullptr, Energy const* energy = nullptr)
{
    using report::thousands;
    TraceSection section;
    auto const steps = step_costs(trace, cost);
    section.steps_svg = steps_svg(model, steps);
    section.supersteps_svg = supersteps_svg(trace, model, cost, grid);
    for (auto const& s : steps)
        section.steps.push_back({s.kernel, thousands(s.supersteps), thousands(s.compute), thousands(s.exchange), thousands(s.sync),
                                 thousands(s.vote), thousands(s.total()), milliseconds_text(model, s.total()),
                                 report::share_text(static_cast<double>(s.total()), static_cast<double>(cost.cycles))});
    auto const ideal = any_to_any(model, trace, grid);
    for (auto const& s : ideal.steps)
        section.ideal.push_back(
            {s.kernel, thousands(s.news_cycles), thousands(s.bound_cycles), thousands(s.replaced ? s.supersteps : 0)});
    section.ideal.push_back(
        {"all", thousands(ideal.news_cycles), thousands(ideal.bound_cycles), thousands(ideal.supersteps_replaced)});
    if (energy != nullptr && energy_model != nullptr) {
        for (auto const& event : energy->events)
            if (event.count != 0) // then the event's energy is set
                section.energy_kinds.push_back({event.name, thousands(event.count),
                                                thousands(model_detail::find_energy(*energy_model, event.name)->value),
                                                report::joules_text(event.joules), report::share_text(event.joules, energy->joules)});
        for (std::size_t s = 0; s < steps.size(); ++s)
            section.energy_steps.push_back({steps[s].kernel, report::joules_text(energy->joules_of_step[s]),
                                            report::share_text(energy->joules_of_step[s], energy->joules)});
    }
    return section;
}

/// Adds the run to a page: cycles by step and over time, ideal routing, energy, and the maps. `legend_png` is a picture of
/// report::heat_legend; empty: no legend.
inline void add_section(report::HtmlReport& html, TraceSection const& section, std::string const& legend_png)
{
    html.svg(section.steps_svg);
    html.table({"step", "supersteps", "compute", "exchange", "sync", "vote", "cycles", "ms", "share"}, section.steps);
    html.svg(section.supersteps_svg);
    html.subsection("Ideal routing");
    html.table({"step", "cycles hop by hop", "bound", "supersteps replaced"}, section.ideal);
    html.paragraph("Exchange, sync and vote of each step, hop by hop as modelled above, and if every message went from any tile "
                   "straight to where it stays, in one exchange. This is a bound and no machine: nobody asks where a record "
                   "is, and the busiest receiver never waits. Steps of one kernel that follow each other are one line; compute "
                   "is in neither column.");
    if (!section.energy_kinds.empty()) {
        html.subsection("Energy");
        html.table({"event", "count", "fJ each", "joules", "share"}, section.energy_kinds);
        html.table({"step", "joules", "share"}, section.energy_steps);
    }
    if (section.maps.empty()) return;
    html.subsection("Maps of the grid");
    if (!legend_png.empty())
        html.picture(legend_png, "colours from dark blue over green to yellow", "From 0 (left) to the most that a tile has (right).");
    for (auto const& [caption, png] : section.maps) html.picture(png, caption, caption, report::HtmlPicture::small);
}

/// Adds the numbers of a cost model, each with its source.
inline void add_parameters(report::HtmlReport& html, CostModel const& model)
{
    html.section("Cost model " + model.name);
    std::vector<std::vector<std::string>> rows;
    for (auto const& p : model.parameters) rows.push_back({p.name, report::thousands(p.value), p.unit, p.source});
    html.table({"parameter", "value", "unit", "source"}, rows);
}
/// Adds the numbers of an energy model, each with its source.
inline void add_parameters(report::HtmlReport& html, EnergyModel const& model)
{
    html.section("Energy model " + model.name);
    std::vector<std::vector<std::string>> rows;
    for (auto const& p : model.events) rows.push_back({p.name, report::thousands(p.value), p.unit, p.source});
    html.table({"event", "value", "unit", "source"}, rows);
}

}} // namespace tilemesh
