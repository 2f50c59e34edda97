#include "tables.hpp"
#include "views.hpp"
#include <algorithm>
#include <cmath>
#include <common/scenes.hpp>
#include <common/statistics.hpp>
#include <functional>
#include <glm/geometric.hpp>
#include <random>
#include <tilemesh/report/plot.hpp>
#include <tilemesh/scene/trajectory.hpp>

namespace paper {

namespace {

constexpr std::uint32_t nowhere = 0xffffffffu;
constexpr double radians = 3.14159265358979323846 / 180.0;

/// A motion of the authors' public experiment (tools/churn_experiment.cpp in nmjfry/ipu-3dgs), with the paper's row.
struct Motion {
    char const* name;
    std::uint32_t frames; ///< number of cameras; the counts are means over one less
    std::function<scene::Pose(std::uint32_t)> pose;
    double moved = 0, churn_percent = 0; ///< the paper's figures
    char const* free = "";               ///< the facts that the paper does not state, from the experiment
};

std::vector<Motion> motions_about(Ball const& ball)
{
    auto const up_is = glm::dvec3(0.0, -1.0, 0.0); // look_at takes the down direction
    auto const start = ball.centre + glm::dvec3(0.0, 0.0, 2 * ball.radius);
    auto const orbit = [=](double degrees) {
        return [=](std::uint32_t k) {
            double const angle = degrees * k * radians;
            auto const from = ball.centre + 2 * ball.radius * glm::dvec3(std::sin(angle), 0.0, std::cos(angle));
            return scene::look_at(from, ball.centre, up_is);
        };
    };
    auto const translate = [=](std::uint32_t k) { return scene::look_at(start - glm::dvec3(0.0, 0.0, 0.001 * ball.radius * k), ball.centre, up_is); };
    auto const rotate = [=](std::uint32_t k) {
        double const angle = k * radians;
        return scene::look_at(start, start + glm::dvec3(std::sin(angle), 0.0, -std::cos(angle)), up_is);
    };
    auto const teleport = [=](std::uint32_t k) {
        // One generator per frame, seeded 42 + k, and three draws in [-1, 1). They are arguments of one call, so C++ leaves their order to
        // the compiler. The order "z first" is fitted to the paper's count.
        std::mt19937 random(42 + k);
        auto const draw = [&] { return static_cast<double>(random()) / 2147483648.0 - 1.0; };
        double const z = draw(), y = draw(), x = draw();
        return scene::look_at(ball.centre + 2 * ball.radius * glm::normalize(glm::dvec3(x, y, z)), ball.centre, up_is);
    };
    return {
        {"Orbit 0.1 deg", 300, orbit(0.1), 138, 0.55, ""},
        {"Orbit 0.5 deg", 300, orbit(0.5), 616, 2.45, ""},
        {"Orbit 2.0 deg", 300, orbit(2.0), 2745, 10.91, ""},
        {"Pure translation", 300, translate, 56, 0.22, "0.001 of the ball's radius forward a frame"},
        {"Pure rotation 1 deg", 300, rotate, 1634, 11.99, "about the camera's vertical axis"},
        {"Random teleport", 100, teleport, 24595, 97.75,
         "cameras at 2 radii in random directions; fitted: the order of three draws, because the source leaves it open"},
    };
}

/// The anchor tiles of the authors' experiment: the tile of the pixel coordinate, rounded to the nearest integer, with its origin at the
/// centre of the first pixel. `nowhere` for a mean that is off the screen or not beyond the near plane.
std::vector<std::uint32_t> authors_anchors(scene::Map const& map, scene::Pose const& pose, scene::Intrinsics const& lens)
{
    std::vector<std::uint32_t> out(map.gaussians.size(), nowhere);
    for (std::size_t i = 0; i < out.size(); ++i) {
        auto const& m = map.gaussians[i].mean_world;
        auto const p = pose.rotation * (glm::dvec3(m[0], m[1], m[2]) - pose.position);
        if (!(p.z > 0.2)) continue;
        double const u = lens.fx * p.x / p.z + lens.cx - 0.5, v = lens.fy * p.y / p.z + lens.cy - 0.5;
        if (!(u >= 0 && u < 1280 && v >= 0 && v < 720)) continue;
        auto const x = static_cast<std::uint32_t>(std::nearbyint(u)) / 32, y = static_cast<std::uint32_t>(std::nearbyint(v)) / 20;
        if (x < grid_columns && y < grid_rows) out[i] = y * grid_columns + x;
    }
    return out;
}

struct Counted {
    double moved = 0;                            ///< Gaussians per frame, mean
    double share_on_screen = 0;                  ///< share of the Gaussians on screen in both frames, mean over frames
    double hops = 0;                             ///< of a Gaussian that moved
    std::uint32_t empty = 0;                     ///< frames in which no Gaussian moved
    std::uint32_t least = 0xffffffffu, most = 0; ///< in a frame
};

Counted count(scene::Map const& map, Motion const& motion, scene::Intrinsics const& lens)
{
    Counted c;
    std::vector<std::uint32_t> before;
    std::uint64_t moved_in_all = 0, hops = 0;
    for (std::uint32_t k = 0; k < motion.frames; ++k) {
        auto now = authors_anchors(map, motion.pose(k), lens);
        if (k > 0) {
            std::uint32_t moved = 0, both = 0;
            for (std::size_t i = 0; i < now.size(); ++i) {
                if (now[i] == nowhere || before[i] == nowhere) continue;
                ++both;
                if (now[i] == before[i]) continue;
                ++moved;
                hops += hops_between(now[i], before[i]);
            }
            moved_in_all += moved;
            c.share_on_screen += both == 0 ? 0 : static_cast<double>(moved) / both;
            c.empty += moved == 0 ? 1 : 0;
            c.least = std::min(c.least, moved);
            c.most = std::max(c.most, moved);
        }
        before = std::move(now);
    }
    auto const frames = motion.frames - 1;
    c.moved = static_cast<double>(moved_in_all) / frames;
    c.share_on_screen /= frames;
    c.hops = moved_in_all == 0 ? 0 : static_cast<double>(hops) / static_cast<double>(moved_in_all);
    return c;
}

/// Counts the records that our mesh moves and those whose anchor tile changes by our projection, frame by frame of one motion.
void count_on_mesh(Context const& context, scene::Map const& map, Motion const& motion, std::uint32_t frames, Rows& rows)
{
    auto const machine = make_watched(map, {.threads = context.threads, .storage_slots = 20'000});
    std::vector<std::uint32_t> at(map.gaussians.size());
    auto const share = (at.size() + tiles - 1) / tiles;
    for (std::size_t i = 0; i < at.size(); ++i) at[i] = static_cast<std::uint32_t>(i / share);
    std::uint64_t on_mesh = 0, projected = 0, different = 0;
    for (std::uint32_t k = 0; k <= frames; ++k) {
        auto const camera = scene::make_camera(motion.pose(k), authors_lens());
        auto const view = splat::make_view(camera, {});
        auto const tiling = tiling_of(camera);
        std::uint64_t moved = 0;
        for (std::size_t i = 0; i < at.size(); ++i) {
            auto const s = splat::project(map.gaussians[i], view, tiling);
            if (!s.visible() || index_of(s.anchor) == at[i]) continue;
            at[i] = index_of(s.anchor);
            ++moved;
        }
        machine->render(camera);
        auto const counted = machine->report().gaussians.moved;
        different += counted != moved ? 1 : 0;
        if (k == 0) continue;
        on_mesh += counted;
        projected += moved;
    }
    Row row{"churn",
            motion.name,
            "records our mesh routes (a frame)",
            {},
            static_cast<double>(on_mesh) / frames,
            "counted",
            "mean of " + std::to_string(frames) +
                " frames after a cold start, on a machine with room for these far views; by projection with our anchors " +
                bench::fixed(static_cast<double>(projected) / frames, 2) +
                (different == 0 ? ", the same in each frame and in the cold start" : ", NOT the same in each frame")};
    row.broken = different != 0;
    rows.push_back(row);
}

/// The same counts on the paths of the authors' benchmark. The paper's churn table does not use these paths.
void count_recorded(Context const& context, scene::Map const& map, scene::Intrinsics const& lens, Rows& rows)
{
    for (auto const& [file, name] : {std::pair{"sloth_orbit", "recorded orbit 0.5 deg"}, std::pair{"sloth_teleport", "recorded teleport"}}) {
        auto const path = context.data / "trajectories" / (std::string(file) + ".tum");
        auto row = skipped("churn", name, "moved (Gaussians a frame)", {}, "counted", path.filename().string() + " is not there");
        if (std::filesystem::exists(path)) {
            auto const poses = scene::load_tum(path);
            if (poses.size() < 2) {
                row.note = "skipped: " + path.filename().string() + " has " + std::to_string(poses.size()) + " poses, and a count is between two";
                rows.push_back(row);
                continue;
            }
            auto const frames = static_cast<std::uint32_t>(context.quick ? std::min<std::size_t>(poses.size(), 41) : poses.size());
            Motion const motion{name, frames, [&](std::uint32_t k) { return poses[k].pose; }};
            auto const c = count(map, motion, lens);
            row.ours = c.moved;
            row.note = "mean of " + std::to_string(frames - 1) + " frames, from " + std::to_string(c.least) + " to " + std::to_string(c.most) +
                       "; the authors' benchmark path, much nearer than the cameras of the churn table; on screen in both " +
                       bench::fixed(100 * c.share_on_screen, 2) + " % move";
        }
        rows.push_back(row);
    }
}

} // namespace

void churn(Context const& context, Rows& rows)
{
    bool const there = bench::has_scene("sloth", context.data);
    bench::Scene sloth;
    if (there) sloth = bench::load_scene("sloth", context.data, {1280, 720});
    auto const& map = sloth.map;
    auto const motions = motions_about(ball_of(map));
    report::Plot plot;
    plot.title = "Sloth: Gaussians whose anchor tile changes";
    plot.x = {.label = "degrees a frame on the orbit", .scale = report::PlotScale::logarithmic};
    plot.y = {.label = "Gaussians a frame", .scale = report::PlotScale::logarithmic};
    plot.series = {{.name = "the paper", .points = {}, .colour = 0, .dashed = true}, {.name = "counted", .points = {}, .colour = 5}};
    double const degrees[] = {0.1, 0.5, 2.0};
    std::uint32_t hits = 0, i = 0;
    for (auto const& motion : motions) {
        std::string const where =
            std::string("the cameras are those of the authors' public experiment: 2 radii of the box's ball from its centre, 60 "
                        "degrees vertical; no step is fitted") +
            (*motion.free == '\0' ? "" : std::string("; ") + motion.free);
        if (!there) {
            rows.push_back(skipped("churn", motion.name, "moved (Gaussians a frame)", motion.moved, "counted", "no map of Sloth"));
            continue;
        }
        auto const c = count(map, motion, authors_lens());
        auto const n = static_cast<double>(map.gaussians.size());
        auto const frames = std::to_string(motion.frames - 1);
        bool const hit = c.moved <= 1.3 * motion.moved && motion.moved <= 1.3 * c.moved;
        hits += hit ? 1 : 0;
        rows.push_back({"churn", motion.name, "moved (Gaussians a frame)", motion.moved, c.moved, "counted",
                        std::string(hit ? "hit" : "MISS") + "; mean of " + frames + " frames, from " + std::to_string(c.least) + " to " +
                            std::to_string(c.most) + "; " + where});
        rows.push_back({"churn", motion.name, "churn, of all (%)", motion.churn_percent, 100 * c.moved / n, "counted",
                        "the paper's count over 25,161 is " + std::to_string(100 * motion.moved / 25161)});
        rows.push_back({"churn", motion.name, "churn, of those on screen in both frames (%)", motion.churn_percent, 100 * c.share_on_screen,
                        "counted",
                        "the experiment's definition of churn: the mean of the frames' shares, 0 for a frame with nothing on screen; " +
                            std::to_string(c.empty) + " of " + frames + " frames move nothing"});
        rows.push_back({"churn", motion.name, "hops of one that moved", {}, c.hops, "counted"});
        if (i < 3) {
            plot.series[0].points.emplace_back(degrees[i], motion.moved);
            plot.series[1].points.emplace_back(degrees[i], c.moved);
        }
        ++i;
    }
    if (!there) return;
    rows.push_back({"churn", "all motions", "counts within a factor 1.3 (of 6)", 6.0, static_cast<double>(hits), "counted",
                    "all rows use one camera and one radius; only the order of the teleport's draws is fitted"});
    std::vector<std::uint32_t> anchors(tiles);
    for (auto const tile : authors_anchors(map, motions.front().pose(0), authors_lens()))
        if (tile != nowhere) ++anchors[tile];
    auto const fullest = static_cast<double>(*std::max_element(anchors.begin(), anchors.end()));
    rows.push_back({"churn",
                    "first camera",
                    "anchors on the fullest tile",
                    {},
                    fullest,
                    "counted",
                    "the paper's storage has 3,200 slots and its code has 800, so no mesh can run these far views; they are projected"});
    count_on_mesh(context, map, motions[1], context.quick ? 4 : 40, rows);
    count_recorded(context, map, scene::lens_of(sloth.camera), rows);
    if (!context.out.empty()) report::write_svg(context.out / "churn.svg", plot);
}

} // namespace paper
