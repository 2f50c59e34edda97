#include "tables.hpp"
#include "views.hpp"
#include <algorithm>
#include <common/scenes.hpp>
#include <glm/matrix.hpp>

namespace paper {

namespace {

/// The distances of records and copies in a view, from the tiles where the records are. A router without full channels takes these hops.
struct Distances {
    std::uint32_t record = 0;  ///< hops of the farthest record to its anchor tile
    std::uint32_t copy = 0;    ///< hops of the record plus hops along its tree, for the record and copy with the largest sum
    std::uint32_t tree = 0;    ///< steps of the deepest tree
    std::uint32_t records = 0; ///< number of records that move
};

/// Computes the distances from placement and views alone, without a machine. `at`: each record's tile; the function updates it.
Distances walk(scene::Map const& map, splat::Camera const& camera, std::vector<std::uint32_t>& at)
{
    splat::Rules rules;
    rules.footprint = splat::Footprint::three_sigma_square;
    auto const view = splat::make_view(camera, rules);
    auto const tiling = tiling_of(camera);
    Distances out;
    for (std::size_t i = 0; i < at.size(); ++i) {
        auto const s = splat::project(map.gaussians[i], view, tiling);
        if (!s.visible()) continue;
        auto const anchor = index_of(s.anchor);
        auto const hops = hops_between(at[i], anchor);
        auto const t = touched_by(s, tiling);
        auto const x = s.anchor.x(), y = s.anchor.y();
        auto const tree = std::max(x - t.x0, t.x1 - x) + std::max(y - t.y0, t.y1 - y);
        out.record = std::max(out.record, hops);
        out.tree = std::max(out.tree, tree);
        out.copy = std::max(out.copy, hops + tree);
        out.records += hops != 0 ? 1 : 0;
        at[i] = anchor;
    }
    return out;
}

/// The camera, moved straight back.
splat::Camera moved_back(splat::Camera const& camera, double by)
{
    auto pose = scene::pose_of(camera);
    pose.position -= by * (glm::transpose(pose.rotation) * glm::dvec3(0.0, 0.0, 1.0));
    return scene::make_camera(pose, scene::lens_of(camera));
}

void rows_of(Context const& context, bench::Scene const& scene, std::string const& name, splat::Camera const& start, double zoom_step,
             std::string const& where, Rows& rows)
{
    struct View {
        char const* name;
        splat::Camera camera;
        double paper;
    };
    View const views[] = {{"cold start", start, 55}, {"zoom 1.0 to 1.2", moved_back(start, zoom_step), 11}};
    std::vector<std::uint32_t> at(scene.map.gaussians.size());
    auto const share = (at.size() + tiles - 1) / tiles;
    for (std::size_t i = 0; i < at.size(); ++i) at[i] = static_cast<std::uint32_t>(i / share);
    std::vector<Distances> predicted;
    for (auto const& v : views) predicted.push_back(walk(scene.map, v.camera, at));

    for (std::uint32_t const slots : {400u, 100u}) {
        auto const machine = make_watched(
            scene.map,
            {.threads = context.threads, .channel_slots = slots, .storage_slots = 20'000, .footprint = splat::Footprint::three_sigma_square});
        for (std::size_t i = 0; i < std::size(views); ++i) {
            auto const& v = views[i];
            auto const& p = predicted[i];
            std::string const row = name + ", " + v.name;
            if (slots == 400) {
                rows.push_back({"convergence", row, "substeps to the farthest anchor", v.paper, static_cast<double>(p.record), "predicted",
                                where + "; records in the file's order, evenly over 40 x 36 tiles, before the cold start; " +
                                    std::to_string(p.records) + " records move"});
                rows.push_back({"convergence", row, "substeps to the farthest copy", v.paper, static_cast<double>(p.copy), "predicted",
                                "the path to the anchor and the tree of one record; the deepest tree has " + std::to_string(p.tree) +
                                    " steps; footprints are 3-sigma squares"});
            }
            machine->render(v.camera);
            auto const& r = machine->report();
            auto const route = r.exchanges.route, bloom = r.exchanges.bloom;
            Row counted{"convergence",
                        row,
                        "exchanges on our mesh, " + std::to_string(slots) + " slots a channel",
                        v.paper,
                        static_cast<double>(route + bloom),
                        "counted",
                        std::to_string(route) + " of routing, then " + std::to_string(bloom) + " of bloom; " + std::to_string(r.gaussians.held) +
                            " records held, " + std::to_string(r.peak_channel) + " at most in a channel" +
                            (slots == 400 ? ", the paper's slots" : ", the slots of its public code")};
            // If no channel is full, a record takes exactly its distance.
            counted.broken = r.gaussians.held == 0 && route != p.record;
            rows.push_back(counted);
        }
    }
}

} // namespace

void convergence(Context const& context, Rows& rows)
{
    constexpr double widest = std::max(grid_columns, grid_rows), farthest = grid_columns - 1 + grid_rows - 1;
    rows.push_back({"convergence", "40 x 36 tiles", "bound on routing, max(W, H)", 40.0, widest, "arithmetic", "the paper's text"});
    rows.push_back({"convergence", "40 x 36 tiles", "bound on routing, |dx| + |dy|", 40.0, farthest, "arithmetic",
                    "a router that goes along one axis, then the other, needs this many; the paper's own 55 is above its 40"});
    bool any = false;
    for (std::string const name : {"sloth", "salad"}) {
        if (!bench::has_scene(name, context.data)) {
            rows.push_back(skipped("convergence", name, "substeps to the farthest anchor", 55.0, "predicted", "its map is not there"));
            continue;
        }
        any = true;
        auto const scene = bench::load_scene(name, context.data, {1280, 720});
        auto const ball = ball_of(scene.map);
        // Zoom z moves the authors' camera back by half a radius times (z - 1).
        auto const step = 0.5 * ball.radius * 0.2;
        rows_of(context, scene, name, authors_camera(ball, 2), step, "the start view of the authors' public convergence benchmark", rows);
        if (!context.quick)
            rows_of(context, scene, name + " from the recorded pose", scene.camera, step, "the pose of the authors' recorded benchmark", rows);
    }
    if (any) return;
    auto const scene = bench::load_scene("built_in", context.data, {1280, 720});
    rows_of(context, scene, "built_in", scene.camera, 0.1 * ball_of(scene.map).radius, "the built-in camera", rows);
}

} // namespace paper
