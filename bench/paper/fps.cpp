#include "machines.hpp"
#include "tables.hpp"
#include <algorithm>
#include <common/scenes.hpp>
#include <common/statistics.hpp>
#include <tilemesh/report/plot.hpp>

void paper::fps(Context const& context, Rows& rows)
{
    using tilemesh::report::PlotScale;
    tilemesh::report::Plot plot;
    plot.title = "Modelled frames a second of our kernels on Mk2, 1280 x 720, orbit 0.5 degrees a frame";
    plot.x = {.label = "Gaussians", .scale = PlotScale::logarithmic};
    plot.y = {.label = "frames a second", .low = 0};
    plot.series = {{.name = "SLAM maps", .points = {}, .colour = 5}, {.name = "object captures", .points = {}, .colour = 4}};
    double sum = 0;
    std::uint32_t of_the_paper = 0;
    for (std::string const name : {"sloth", "salad", "fruit_drops_sh3", "playbot_31k_sh2", "playbot_250k", "built_in"}) {
        bool const authors = name == "sloth" || name == "salad";
        if (context.quick && name == "playbot_250k") {
            rows.push_back(skipped("fps", name, "frames a second", {}, "modelled", "--quick"));
            continue;
        }
        if (!bench::has_scene(name, context.data)) {
            rows.push_back(skipped("fps", name, "frames a second", {}, "modelled", "its map is not there"));
            continue;
        }
        auto const m = model_scene(context, name);
        auto const fps = 1000 / m.milliseconds;
        if (authors) sum += fps, ++of_the_paper;
        rows.push_back({"fps",
                        name,
                        "frames a second",
                        {},
                        fps,
                        "modelled",
                        std::to_string(m.gaussians) + " Gaussians; the preset lossless and the parameters mk2; mean of " + std::to_string(m.frames) +
                            " orbit frames, " + bench::fixed(m.least, 3) + " to " + bench::fixed(m.most, 3) + " ms; cold start " +
                            bench::fixed(m.first, 3) + " ms, static view " + bench::fixed(m.static_view, 3) + " ms" +
                            (m.complete ? "" : "; storage was short: the picture lacks some")});
        rows.push_back({"fps", name, "frame time (ms)", {}, m.milliseconds, "modelled"});
        plot.series[authors ? 0 : 1].points.emplace_back(static_cast<double>(m.gaussians), fps);
    }
    Row mean{"fps",
             "mean",
             "frames a second",
             19.80,
             {},
             "modelled",
             "the paper's value is the mean of Sloth, Chairs, Salad and Pringles on its prototype; the text gives no number for its "
             "figure of fps against Gaussians"};
    if (of_the_paper != 0) {
        mean.ours = sum / of_the_paper;
        mean.note += "; ours is the mean of Sloth and Salad with our kernels; the table stage has the costs of the prototype";
    } else {
        mean.note += "; skipped: neither Sloth nor Salad is there";
    }
    rows.push_back(mean);
    for (auto& series : plot.series) std::sort(series.points.begin(), series.points.end());
    if (!context.out.empty()) tilemesh::report::write_svg(context.out / "fps.svg", plot);
}
