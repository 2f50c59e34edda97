#include "plots.hpp"
#include "findings.hpp"
#include <limits>
#include <string>
#include <tilemesh/report/plot.hpp>

namespace channel_capacity {

namespace {

using tilemesh::report::Plot;
using tilemesh::report::PlotLine;
using tilemesh::report::PlotScale;
using tilemesh::report::PlotSeries;

/// The motions that are drawn. The other motions lie between these.
struct Drawn {
    char const* motion;
    char const* name;
    std::uint32_t colour;
};
constexpr Drawn drawn[] = {{"teleport", "teleport", 5},
                           {"static", "cold start", 1},
                           {"fr1_xyz", "hand-held fr1_xyz", 3},
                           {"orbit2", "orbit 2 deg", 4},
                           {"orbit0.5", "orbit 0.5 deg", 2}};

template <class Value>
PlotSeries series_of(std::vector<Row> const& rows, std::string const& name, std::uint32_t colour, Value const& value)
{
    PlotSeries series{.name = name, .points = {}, .colour = colour};
    for (auto const& r : rows) series.points.emplace_back(r.capacity, value(r));
    return series;
}

double modelled_ms(Row const& r)
{
    return tilemesh::milliseconds(cost_model(), r.cycles_most());
}
/// The Pareto fronts of the drawn motions. For the first motion that was measured, the other splits too, as dots without a line.
Plot pareto_plot(std::vector<Row> const& rows, std::string const& scene)
{
    Plot plot;
    plot.title = scene + ": picture against modelled time, one SRAM budget";
    plot.x = {.label = "modelled ms of the slowest frame (Mk2)", .scale = PlotScale::logarithmic};
    plot.y = {.label = "PSNR of the worst frame (dB)"};
    plot.infinity = "equal";
    for (auto const& d : drawn) {
        auto const all = by_time(rows, scene, d.motion);
        if (all.empty()) continue;
        auto const front = pareto_front(all);
        bool const first = plot.series.empty();
        PlotSeries best{.name = std::string(d.name) + ": front", .points = {}, .line = PlotLine::step, .colour = d.colour};
        for (std::size_t i = 0; i < all.size(); ++i)
            if (front[i]) best.points.emplace_back(modelled_ms(all[i]), all[i].worst.psnr_db);
        plot.series.push_back(best);
        if (!first) continue;
        for (auto const saturation : {Saturation::hold, Saturation::drop}) {
            PlotSeries others{.name = std::string(d.name) + ": other, " + to_string(saturation),
                              .points = {},
                              .colour = saturation == Saturation::hold ? 0u : 7u};
            for (std::size_t i = 0; i < all.size(); ++i) {
                if (front[i] || all[i].saturation != saturation) continue;
                auto const x = modelled_ms(all[i]);
                others.points.emplace_back(x, all[i].worst.psnr_db);
                others.points.emplace_back(x, std::numeric_limits<double>::quiet_NaN()); // a gap
            }
            if (!others.points.empty()) plot.series.push_back(others);
        }
    }
    return plot;
}

} // namespace

void write_plots(std::filesystem::path const& folder, std::vector<Row> const& rows, std::vector<LatencyRow> const& latency)
{
    for (auto const* scene : scene_names) {
        Plot psnr, steps;
        psnr.title = std::string(scene) + ": the worst frame of a motion, one SRAM budget";
        psnr.x = {.label = "slots of every channel; storage has the bytes that are left", .scale = PlotScale::logarithmic};
        psnr.y = {.label = "PSNR (dB)"};
        psnr.infinity = "equal";
        steps = psnr;
        steps.title = std::string(scene) + ": what full channels cost under hold";
        steps.y = {.label = "exchanges a frame (mean)", .scale = PlotScale::logarithmic};
        for (auto const& d : drawn) {
            auto const dropped = select(rows, scene, d.motion, Saturation::drop), held = select(rows, scene, d.motion, Saturation::hold);
            if (dropped.empty()) continue;
            psnr.series.push_back(
                series_of(dropped, std::string("drop, ") + d.name, d.colour, [](Row const& r) { return r.worst.psnr_db; }));
            steps.series.push_back(
                series_of(held, d.name, d.colour, [](Row const& r) { return static_cast<double>(r.exchanges) / r.frames; }));
        }
        auto const held = select(rows, scene, "teleport", Saturation::hold);
        if (!held.empty()) {
            psnr.series.push_back(series_of(held, "hold, teleport", drawn[0].colour, [](Row const& r) { return r.worst.psnr_db; }));
            psnr.series.back().dashed = true;
        }
        Plot programs;
        programs.title = std::string(scene) + ": a slot costs losses, or time";
        programs.x = psnr.x;
        programs.y = {.label = "modelled ms of the slowest frame (Mk2)", .scale = PlotScale::logarithmic};
        for (auto const& d : drawn) {
            auto const homes = select(rows, scene, d.motion, Saturation::homes), anchored = select(rows, scene, d.motion, Saturation::hold);
            if (homes.empty() || (std::string(d.motion) != "teleport" && std::string(d.motion) != "static" && std::string(d.motion) != "orbit0.5")) continue;
            programs.series.push_back(series_of(homes, std::string("homes, ") + d.name, d.colour, modelled_ms));
            programs.series.push_back(series_of(anchored, std::string("anchored where complete, ") + d.name, d.colour, [](Row const& r) {
                return r.complete() ? modelled_ms(r) : std::numeric_limits<double>::quiet_NaN();
            }));
            programs.series.back().dashed = true;
        }
        if (!programs.series.empty()) tilemesh::report::write_svg(folder / (std::string(scene) + "_programs.svg"), programs);
        if (psnr.series.empty()) continue;
        tilemesh::report::write_svg(folder / (std::string(scene) + "_pareto.svg"), pareto_plot(rows, scene));
        tilemesh::report::write_svg(folder / (std::string(scene) + "_psnr.svg"), psnr);
        tilemesh::report::write_svg(folder / (std::string(scene) + "_supersteps.svg"), steps);
    }
    if (latency.empty()) return;
    Plot plot;
    plot.title = latency.front().scene + ": how late a Gaussian is after a teleport";
    plot.x = {.label = "tiles that its anchor moved"};
    plot.y = {.label = "frames late", .low = 0};
    for (auto const& r : latency) {
        if (r.scene != latency.front().scene) break;
        auto const name = std::to_string(r.hops) + (r.hops == 1 ? " hop a frame" : " hops a frame");
        if (plot.series.empty() || plot.series.back().name != name)
            plot.series.push_back({.name = name,
                                   .points = {},
                                   .line = PlotLine::step,
                                   .colour = static_cast<std::uint32_t>(plot.series.size()) + 2});
        plot.series.back().points.emplace_back(r.distance, r.late_median);
    }
    tilemesh::report::write_svg(folder / "latency.svg", plot);
}

} // namespace channel_capacity
