// test: optimised, without asan, cost 10
#include "points.hpp"
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/naive.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/rules.hpp>
#include <tilemesh/track/pose_solver.hpp>
#include <tilemesh/track/spoil.hpp>
#include <tilemesh/track/tracker.hpp>
#include <tilemesh/track/trajectory_error.hpp>

using namespace track_test;

namespace {

/// Colour, and depth times coverage and coverage, of each pixel or cell.
struct Picture {
    std::uint32_t width = 0, height = 0;
    std::vector<double> rgb, depth, cover;
    double colour(std::uint32_t x, std::uint32_t y, std::size_t c) const { return rgb[3 * (std::size_t{y} * width + x) + c]; }
};

Picture render(scene::Map const& map, splat::Camera const& camera)
{
    splat::Rules const rules{};
    auto const image = report::render_naive(std::span<splat::Gaussian const>(map.gaussians), camera, rules);
    // The same blending of other colours: the depth of the mean, and 1.
    auto painted = map.gaussians;
    for (auto& g : painted) {
        g.colour[0] = static_cast<float>(in_view(camera, {g.mean_world[0], g.mean_world[1], g.mean_world[2]}).z);
        g.colour[1] = 1.0f;
    }
    auto const planes = report::render_naive(std::span<splat::Gaussian const>(painted), camera, rules);
    Picture out{camera.width, camera.height, {image.rgb.begin(), image.rgb.end()}, {}, {}};
    for (std::size_t i = 0; i < std::size_t{out.width} * out.height; ++i) {
        out.depth.push_back(double{planes.rgb[3 * i]});
        out.cover.push_back(double{planes.rgb[3 * i + 1]});
    }
    return out;
}

/// Means over whole cells.
Picture cells_of(Picture const& full, std::uint32_t cell)
{
    Picture out{full.width / cell, full.height / cell, {}, {}, {}};
    auto const pixels = std::size_t{out.width} * out.height;
    out.rgb.resize(3 * pixels), out.depth.resize(pixels), out.cover.resize(pixels);
    double const share = 1.0 / (cell * cell);
    for (std::uint32_t y = 0; y < out.height * cell; ++y)
        for (std::uint32_t x = 0; x < out.width * cell; ++x) {
            std::size_t const to = std::size_t{y / cell} * out.width + x / cell, from = std::size_t{y} * full.width + x;
            for (std::size_t c = 0; c < 3; ++c) out.rgb[3 * to + c] += share * full.rgb[3 * from + c];
            out.depth[to] += share * full.depth[from];
            out.cover[to] += share * full.cover[from];
        }
    return out;
}

/// An evaluator by image gradients, in double: for `forward` and `esm` the mean of the gradients of map and target, else those of the map.
struct ByGradients {
    scene::Map const* map;
    Picture target;
    double scale;
    bool with_exposure = false;

    track::NormalEquations operator()(splat::Camera const& camera, track::Level const& level) const
    {
        auto const now = cells_of(render(*map, camera), level.cell), seen = cells_of(target, level.cell);
        double const fx = double{camera.fx} / level.cell, fy = double{camera.fy} / level.cell, cx = double{camera.cx} / level.cell, cy = double{camera.cy} / level.cell;
        double const gain = std::exp(level.exposure.log_gain);
        bool const both = level.jacobian != track::Jacobian::gradient;
        track::NormalEquations e;
        e.unknowns = with_exposure ? 8 : 6;
        for (std::uint32_t y = 1; y + 1 < now.height; ++y)
            for (std::uint32_t x = 1; x + 1 < now.width; ++x) {
                std::size_t const i = std::size_t{y} * now.width + x;
                if (now.cover[i] < 0.5) continue;
                ++e.pixels;
                double const z = now.depth[i] / now.cover[i], sx = (x + 0.5 - cx) / fx, sy = (y + 0.5 - cy) / fy;
                double const du[6] = {fx * scale / z, 0, -fx * sx * scale / z, -fx * sx * sy, fx * (1 + sx * sx), -fx * sy};
                double const dv[6] = {0, fy * scale / z, -fy * sy * scale / z, -fy * (1 + sy * sy), fy * sx * sy, fy * sx};
                for (std::size_t c = 0; c < 3; ++c) {
                    double gx = 0.5 * gain * (now.colour(x + 1, y, c) - now.colour(x - 1, y, c)), gy = 0.5 * gain * (now.colour(x, y + 1, c) - now.colour(x, y - 1, c));
                    if (both) {
                        gx = 0.5 * gx + 0.25 * (seen.colour(x + 1, y, c) - seen.colour(x - 1, y, c));
                        gy = 0.5 * gy + 0.25 * (seen.colour(x, y + 1, c) - seen.colour(x, y - 1, c));
                    }
                    double j[8];
                    for (int k = 0; k < 6; ++k) j[k] = -(gx * du[k] + gy * dv[k]);
                    j[6] = gain * now.colour(x, y, c);
                    j[7] = 1.0;
                    add_row(e, j, gain * now.colour(x, y, c) + level.exposure.offset - seen.colour(x, y, c), 0.1);
                }
            }
        return e;
    }
};

struct Desk {
    scene::Map map = scene::built_in_map();
    splat::Camera camera = scene::built_in_camera({80, 45});
    double scale = 1.0;
    Desk()
    {
        auto const picture = render(map, camera);
        std::vector<double> depths;
        for (std::size_t i = 0; i < picture.cover.size(); ++i)
            if (picture.cover[i] > 0.5) depths.push_back(picture.depth[i] / picture.cover[i]);
        std::nth_element(depths.begin(), depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2), depths.end());
        scale = depths[depths.size() / 2];
    }
};
Desk const& desk()
{
    static Desk const one;
    return one;
}

} // namespace

TEST_CASE("the solver finds the built-in map's camera from 1 degree and 1 % of the depth, to a hundredth of a degree, by image gradients")
{
    auto const& d = desk();
    auto const truth = scene::pose_of(d.camera);
    ByGradients const evaluate{&d.map, render(d.map, d.camera), d.scale};
    Random random;
    for (auto const method : {track::Method::esm, track::Method::gradient}) {
        auto const start = disturbed(truth, 1.0, 0.01, random, d.scale);
        auto const s = track::solve_pose(evaluate, start, scene::lens_of(d.camera), d.scale, track::stages_of(method, 4));
        MESSAGE("evaluations ", s.evaluations, ", off by ", degrees_between(s.pose.rotation, truth.rotation), " degrees, ", glm::length(s.pose.position - truth.position) / d.scale, " of the depth");
        CHECK(s.converged());
        CHECK(degrees_between(start.rotation, truth.rotation) == doctest::Approx(1.0));
        CHECK(degrees_between(s.pose.rotation, truth.rotation) < 1e-2);
        CHECK(glm::length(s.pose.position - truth.position) < 1e-3 * d.scale);
        CHECK(s.evaluations < 40);
    }
}

TEST_CASE("a short walk over the built-in map is tracked, with noise, 8 bits and a gain that drifts, with 8 unknowns")
{
    auto const& d = desk();
    auto const at = [&](int k) { return scene::make_camera(track::moved(scene::pose_of(d.camera), {{0.01 * k, 0.0, 0.01 * k}, {0.004 * k, 0.006 * k, 0.0}}), scene::lens_of(d.camera)); };
    track::Spoiling spoiling;
    spoiling.gain_drift = 0.5; // over so few frames
    track::TrackerOptions options;
    options.method = track::Method::esm;
    track::Tracker tracker(scene::lens_of(d.camera), d.scale, scene::pose_of(at(0)), options);
    std::vector<scene::Pose> truth, estimated;
    for (int k = 0; k < 5; ++k) {
        auto target = render(d.map, at(k));
        report::Image picture{target.width, target.height};
        std::transform(target.rgb.begin(), target.rgb.end(), picture.rgb.begin(), [](double v) { return static_cast<float>(v); });
        report::Plane none;
        track::spoil(picture, none, static_cast<std::uint64_t>(k), spoiling);
        target.rgb.assign(picture.rgb.begin(), picture.rgb.end());
        auto const f = tracker.track(ByGradients{&d.map, target, d.scale, true});
        INFO(k, " ", f.why);
        CHECK(f.verdict == track::Verdict::converged);
        CHECK(f.exposure.log_gain == doctest::Approx(std::log(track::gain_of(spoiling, static_cast<std::uint64_t>(k)))).epsilon(0.02).scale(1.0));
        truth.push_back(scene::pose_of(at(k)));
        estimated.push_back(f.pose);
        // The error is as large as the covariance says: within five standard deviations of the worst motion.
        CHECK(degrees_between(f.pose.rotation, truth.back().rotation) < 5.0 * f.accuracy.worst_px / double{d.camera.fx} * 180.0 / 3.14159265358979);
    }
    auto const errors = track::trajectory_errors(estimated, truth);
    MESSAGE("ATE ", errors.ate.rmse / d.scale, " of the depth, ", errors.rotation_deg.rmse, " degrees");
    CHECK(errors.rotation_deg.rmse < 0.1); // an eighth of a pixel
    CHECK(errors.ate.rmse < 5e-3 * d.scale);
}

TEST_CASE("a picture of another map is lost")
{
    auto const& d = desk();
    track::TrackerOptions options;
    options.method = track::Method::esm;
    track::Tracker tracker(scene::lens_of(d.camera), d.scale, scene::pose_of(d.camera), options);
    ByGradients good{&d.map, render(d.map, d.camera), d.scale};
    CHECK(tracker.track(good).verdict == track::Verdict::converged);
    auto other = good;
    std::reverse(other.target.rgb.begin(), other.target.rgb.end()); // upside down, mirrored, and red for blue
    auto const f = tracker.track(other);
    CHECK(f.verdict == track::Verdict::lost);
    CHECK(f.pose.position == f.start.position);
}
