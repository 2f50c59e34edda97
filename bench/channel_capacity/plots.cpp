#include "plots.hpp"
#include "findings.hpp"
#include <string>
#include <tilemesh/report/plot.hpp>

namespace channel_capacity {

namespace {

using tilemesh::report::Plot;
using tilemesh::report::PlotScale;
using tilemesh::report::PlotSeries;

/// What is drawn: the other motions lie between these.
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
        steps.y = {.label = "supersteps a frame (mean)", .scale = PlotScale::logarithmic};
        for (auto const& d : drawn) {
            auto const dropped = select(rows, scene, d.motion, Saturation::drop), held = select(rows, scene, d.motion, Saturation::hold);
            if (dropped.empty()) continue;
            psnr.series.push_back(
                series_of(dropped, std::string("drop, ") + d.name, d.colour, [](Row const& r) { return r.worst.psnr_db; }));
            steps.series.push_back(
                series_of(held, d.name, d.colour, [](Row const& r) { return static_cast<double>(r.supersteps) / r.frames; }));
        }
        auto const held = select(rows, scene, "teleport", Saturation::hold);
        if (!held.empty()) {
            psnr.series.push_back(series_of(held, "hold, teleport", drawn[0].colour, [](Row const& r) { return r.worst.psnr_db; }));
            psnr.series.back().dashed = true;
        }
        if (psnr.series.empty()) continue;
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
                                   .line = tilemesh::report::PlotLine::step,
                                   .colour = static_cast<std::uint32_t>(plot.series.size()) + 2});
        plot.series.back().points.emplace_back(r.distance, r.late_median);
    }
    tilemesh::report::write_svg(folder / "latency.svg", plot);
}

} // namespace channel_capacity
