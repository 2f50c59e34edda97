#include "findings.hpp"
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <set>
#include <string_view>
#include <tilemesh/report/plot.hpp>

namespace error_vs_time {

namespace {

using report::Plot;
using report::PlotLine;
using report::PlotScale;
using report::PlotSeries;

/// The knobs in the order of the legend. Knobs with one name are one series, because eight colours are all that a reader can tell apart.
struct Drawn {
    char const* knob;
    char const* name;
    std::uint32_t colour;
};
constexpr Drawn drawn[] = {{"alpha and stop", "alpha and stop", 4},
                           {"sigma", "sigma cut", 1},
                           {"clamp", "clamp, crossing", 6},
                           {"crossing", "clamp, crossing", 6},
                           {"arithmetic", "arithmetic", 3},
                           {"shape", "record, sort key", 2},
                           {"sort key", "record, sort key", 2},
                           {"channels", "channels, hops, storage", 7},
                           {"hops", "channels, hops, storage", 7},
                           {"storage", "channels, hops, storage", 7},
                           {"program", "homes", 5}};
constexpr std::uint32_t named_colours[] = {3, 5, 1, 6}; // for `named_settings`

using Cost = double (*)(Row const&);
double pairs_of(Row const& row)
{
    return static_cast<double>(row.counters.pairs);
}
double millions_of(Row const& row)
{
    return 1e-6 * pairs_of(row);
}
double modelled_of(Row const& row)
{
    return row.modelled_ms;
}
double host_of(Row const& row)
{
    return band_of(row.host_ms, 0.2).median;
}

struct Panel {
    char const* file;
    char const* against;
    char const* label;
    Cost cost;
    bool Row::*on_front;
    bool own_front; ///< the front is that of this cost
};
constexpr Panel panels[] = {
    {"pairs", "work", "Gaussian-pixel pairs evaluated, millions", millions_of, &Row::on_front, true},
    {"modelled", "modelled time", "modelled ms of a frame (Mk2)", modelled_of, &Row::on_front_modelled, true},
    {"host", "host time", "host ms of a frame (median)", host_of, &Row::on_front, false}};

bool has_place(Row const& row, Cost cost)
{
    return ran(row) && row.total.rmse > 0 && std::isfinite(row.total.rmse) && cost(row) > 0 && std::isfinite(cost(row));
}

Plot plot_of(Group const& group, Panel const& panel)
{
    Plot plot;
    plot.title = group.front()->scene + ": error (RMSE) against " + panel.against + ", both logarithmic (down and left is better)";
    plot.x = {.label = panel.label, .scale = PlotScale::logarithmic};
    plot.y = {.label = "RMSE", .scale = PlotScale::logarithmic};
    Group all;
    for (auto const* r : group)
        if (has_place(*r, panel.cost)) all.push_back(r);
    if (all.size() < group.size()) {
        auto const left_out = group.size() - all.size();
        plot.x.label += "; " + std::to_string(left_out) + (left_out == 1 ? " setting" : " settings") + " left out: no result, or an error of 0";
    }
    std::stable_sort(all.begin(), all.end(), [&](Row const* a, Row const* b) { return panel.cost(*a) < panel.cost(*b); });

    auto const add = [&](std::string const& name, std::uint32_t colour, bool faded, auto const& wanted) {
        PlotSeries series{.name = name, .points = {}, .line = PlotLine::none, .colour = colour, .faded = faded};
        for (auto const* r : all)
            if (wanted(*r)) series.points.emplace_back(panel.cost(*r), r->total.rmse);
        if (!series.points.empty()) plot.series.push_back(series);
    };
    char const* last = "";
    for (auto const& d : drawn) {
        if (std::string_view(last) == d.name) continue;
        last = d.name;
        add(d.name, d.colour, true, [&](Row const& r) {
            return !is_named(r) && std::any_of(std::begin(drawn), std::end(drawn), [&](Drawn const& of) {
                return of.knob == r.setting.knob && std::string_view(of.name) == d.name;
            });
        });
    }
    add("other", 0, true, [](Row const& r) {
        return !is_named(r) && std::none_of(std::begin(drawn), std::end(drawn), [&](Drawn const& of) { return of.knob == r.setting.knob; });
    });
    add(panel.own_front ? "front" : "front by pairs", 0, false, [&](Row const& r) { return r.*panel.on_front; });
    if (panel.own_front && !plot.series.empty() && plot.series.back().name == "front") plot.series.back().line = PlotLine::step;
    for (std::size_t i = 0; i < named_settings.size(); ++i) {
        auto const before = plot.series.size();
        add(std::string(named_settings[i]), named_colours[i], false, [&](Row const& r) { return r.setting.name == named_settings[i]; });
        if (plot.series.size() > before) plot.series.back().dot_px = 4; // they lie on top of the front's dots
    }
    auto const before = plot.series.size();
    add("3DGS", 7, false, [](Row const& r) { return r.setting.name == "3DGS"; }); // a setting that readers know
    if (plot.series.size() > before) plot.series.back().dot_px = 4;
    return plot;
}

} // namespace

std::vector<std::string> write_plots(std::filesystem::path const& folder, std::vector<Row> const& rows)
{
    std::vector<std::string> left_out;
    std::set<std::string> done;
    for (auto const& group : groups_of(rows)) {
        auto const& scene = group.front()->scene;
        if (is_sequence(group) || !done.insert(scene).second) continue;
        std::string names;
        for (auto const* r : group)
            if (!has_place(*r, pairs_of)) names += (names.empty() ? "" : ", ") + r->setting.name;
        if (!names.empty()) left_out.push_back("not in the plots of " + scene + " (failed, or an error or pairs of 0): " + names);
        for (auto const& panel : panels) {
            auto const plot = plot_of(group, panel);
            if (!plot.series.empty()) report::write_svg(folder / (scene + "_" + panel.file + ".svg"), plot);
        }
    }
    return left_out;
}

} // namespace error_vs_time
