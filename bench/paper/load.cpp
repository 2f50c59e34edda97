#include "tables.hpp"
#include "views.hpp"
#include <algorithm>
#include <common/pictures.hpp>
#include <common/scenes.hpp>
#include <numeric>
#include <shared/png.hpp>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/orbit.hpp>

namespace paper {

namespace {

struct Spread {
    std::vector<std::uint32_t> held; ///< records and copies per tile
    std::uint32_t most = 0, anchors = 0;
    double mean = 0, least = 0, empty_percent = 0, gini = 0;
    std::uint32_t above_buffer = 0;
};

/// The capacity of the primitive buffer in the paper's figure.
constexpr std::uint32_t render_buffer = 900;

Spread spread(scene::Map const& map, splat::Camera const& camera)
{
    splat::Rules rules;
    rules.footprint = splat::Footprint::three_sigma_square;
    auto const view = splat::make_view(camera, rules);
    auto const tiling = tiling_of(camera);
    Spread out;
    out.held.resize(tiles);
    std::vector<std::uint32_t> anchors(tiles);
    for (auto const& g : map.gaussians) {
        auto const s = splat::project(g, view, tiling);
        if (!s.visible()) continue;
        ++anchors[index_of(s.anchor)];
        for_each_tile(s, tiling, [&](std::uint32_t tile) { ++out.held[tile]; });
    }
    auto sorted = out.held;
    std::sort(sorted.begin(), sorted.end());
    auto const sum = static_cast<double>(std::accumulate(sorted.begin(), sorted.end(), std::uint64_t{0}));
    out.most = sorted.back();
    out.anchors = *std::max_element(anchors.begin(), anchors.end());
    out.least = sorted.front();
    out.mean = sum / tiles;
    out.empty_percent = 100.0 * static_cast<double>(std::count(sorted.begin(), sorted.end(), 0u)) / tiles;
    double ranked = 0; // Gini: sum over ranks of (2 rank - n - 1) value, over n times the sum
    for (std::uint32_t i = 0; i < tiles; ++i) ranked += (2.0 * i + 1.0 - tiles) * sorted[i];
    out.gini = sum > 0 ? ranked / (tiles * sum) : 0;
    out.above_buffer = static_cast<std::uint32_t>(std::count_if(sorted.begin(), sorted.end(), [](auto n) { return n > render_buffer; }));
    return out;
}

struct Viewpoint {
    char const* name;
    splat::Camera camera;
};

/// Near, middle and far views: for the authors' maps the recorded cameras, otherwise a camera that moves to and from the middle.
std::vector<Viewpoint> viewpoints(std::string const& name, Context const& context, bench::Scene const& scene)
{
    std::vector<Viewpoint> out;
    if (name != "built_in") {
        auto const all = scene::load_cameras(context.data / "cameras.json");
        for (auto const& [view, camera] : {std::pair{"near", "close"}, std::pair{"middle", "front"}, std::pair{"far", "far"}})
            out.push_back({view, scene::select_cameras(all, name + "/" + camera, name).front().camera});
        return out;
    }
    auto const centre = scene::robust_centre(scene.map);
    for (auto const& [view, times] : {std::pair{"near", 0.5}, std::pair{"middle", 1.0}, std::pair{"far", 3.0}}) {
        auto pose = scene::pose_of(scene.camera);
        pose.position = centre + times * (pose.position - centre);
        out.push_back({view, scene::make_camera(pose, scene::lens_of(scene.camera))});
    }
    return out;
}

} // namespace

void load(Context const& context, Rows& rows)
{
    std::string const what = "records and copies a tile, 3-sigma squares";
    for (std::string const name : {"sloth", "salad", "built_in"}) {
        if (!bench::has_scene(name, context.data)) {
            rows.push_back(skipped("load", name, "max on a tile", {}, "counted", "its map is not there"));
            continue;
        }
        auto const scene = bench::load_scene(name, context.data, {1280, 720});
        std::vector<Spread> spreads;
        for (auto const& v : viewpoints(name, context, scene)) {
            auto const s = spread(scene.map, v.camera);
            auto const add = [&](char const* quantity, double value, std::string const& note) {
                rows.push_back({"load", name + ", " + v.name, quantity, {}, value, "counted", what + note});
            };
            add("max on a tile", s.most,
                "; at most " + std::to_string(s.anchors) + " anchors; " + std::to_string(s.above_buffer) +
                    " tiles above the figure's render buffer of 900");
            add("min on a tile", s.least, "");
            add("mean on a tile", s.mean, "");
            add("max over mean", s.mean > 0 ? s.most / s.mean : 0, "");
            add("empty tiles (%)", s.empty_percent, "");
            add("Gini coefficient", s.gini, "; 0: even, 1: all on one tile");
            spreads.push_back(s);
        }
        Row even{"load", name, "Gini near over Gini far", {}, spreads.front().gini / spreads.back().gini, "counted", {}};
        even.note = *even.ours < 1 ? "near views spread the load more evenly, as in the paper's figure"
                                   : "near views do NOT spread the load more evenly, unlike in the paper's figure";
        rows.push_back(even);
        if (context.out.empty()) continue;
        std::vector<report::Image> maps;
        for (auto const& s : spreads) maps.push_back(heat_map(s.held, render_buffer));
        shared::write_png(context.out / ("load_" + name + ".png"), bench::side_by_side(maps));
    }
}

} // namespace paper
