#include "tables.hpp"
#include <algorithm>
#include <channel_capacity/latency.hpp>
#include <tilemesh/report/plot.hpp>

void paper::latency(Context const& context, Rows& rows)
{
    tilemesh::report::Plot plot;
    plot.title = "Frames until a Gaussian is on its new anchor tile";
    plot.x = {.label = "tiles that its anchor moved"};
    plot.y = {.label = "frames", .low = 0};
    for (std::string const name : {"sloth", "salad", "built_in"}) {
        if (!bench::has_scene(name, context.data)) {
            rows.push_back(skipped("latency", name, "frames late, farthest", {}, "counted", "its map is not there"));
            continue;
        }
        if (context.quick && (name == "salad" || (name == "built_in" && !context.data.empty()))) {
            rows.push_back(skipped("latency", name, "frames late, farthest", {}, "counted", "--quick"));
            continue;
        }
        // Distances are in tiles, so any size of picture gives the same.
        auto const scene = bench::load_scene(name, context.data, {320, 180});
        std::vector<std::string> broken;
        auto const found = channel_capacity::follow(scene, "teleport", 1, context.data, broken);
        std::uint64_t all = 0, exact = 0;
        for (auto const& r : found.rows) {
            all += r.gaussians;
            exact += r.late_min == r.distance && r.late_max == r.distance ? r.gaussians : 0;
        }
        auto const add = [&](channel_capacity::LatencyRow const& r) {
            rows.push_back({"latency", name, "frames until it is there, " + std::to_string(r.distance) + " tiles off",
                            static_cast<double>(r.distance), static_cast<double>(r.late_max), "counted",
                            "Gaussians: " + std::to_string(r.gaussians) + ", the fastest after " +
                                std::to_string(r.late_min) + "; one hop a frame"});
        };
        std::uint32_t next = 1;
        for (auto const& r : found.rows) {
            if (r.distance < next || &r == &found.rows.back()) continue;
            add(r);
            next = r.distance < 10 ? 10 : r.distance + 15;
        }
        if (!found.rows.empty()) add(found.rows.back());
        rows.push_back({"latency", name, "Gaussians that take d frames for d tiles (%)", 100.0,
                        all == 0 ? 0 : 100.0 * static_cast<double>(exact) / static_cast<double>(all), "counted",
                        std::to_string(all) + " Gaussians after a teleport; " + std::to_string(found.refused) +
                            " refusals; complete with all copies after " + std::to_string(found.frames_until_complete) +
                            " frames",
                        !broken.empty()});
        if (!broken.empty()) rows.back().note = broken.front();
        plot.series.push_back({.name = name, .points = {}, .colour = static_cast<std::uint32_t>(plot.series.size()) + 2});
        for (auto const& r : found.rows) plot.series.back().points.emplace_back(r.distance, r.late_median);
    }
    if (!context.out.empty() && !plot.series.empty()) tilemesh::report::write_svg(context.out / "latency.svg", plot);
}
