// Renders a map along a trajectory, spoils the pictures as a camera would, and finds each pose again on the mesh.
#include "options.hpp"
#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <glm/geometric.hpp>
#include <iostream>
#include <new>
#include <string>
#include <tilemesh/tilemesh.hpp>
#include <tilemesh/track/pose_evaluator.hpp>
#include <utility>
#include <vector>

namespace {

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;
namespace track = tilemesh::track;
using tilemesh::Error;
using track_camera::Options;
using WithPlanes = splat::WithPixel<splat::Lossless, splat::WithAlpha<splat::WithDepth<splat::FloatPixel>>>;

/// A number as JSON has it.
std::string number(double value)
{
    std::array<char, 32> text{};
    auto const end = std::to_chars(text.data(), text.data() + text.size(), value);
    return {text.data(), end.ptr};
}

/// The poses that are rendered.
scene::Trajectory poses_of(Options const& o, scene::Pose const& first)
{
    scene::Trajectory poses;
    if (o.trajectory) {
        poses = scene::load_trajectory(*o.trajectory);
        if (o.relative) poses = scene::relative_to_first(std::move(poses), first);
    } else
        for (std::uint32_t k = 0; k < o.frames; ++k) { // about 1 degree and 1 cm a frame, as a hand moves
            double const t = k / 31.0;
            poses.push_back({t, track::moved(first, {{0.1 * std::sin(2.0 * t), 0.06 * std::sin(3.1 * t), 0.08 * (1.0 - std::cos(1.7 * t))}, {0.05 * std::sin(2.3 * t), 0.12 * std::sin(1.9 * t), 0.03 * std::sin(2.9 * t)}})});
        }
    if (poses.size() > o.frames) poses.resize(o.frames);
    return poses;
}

/// The median depth of what the picture shows. Throws `Error` if it shows nothing.
double median_depth(tilemesh::RenderedFrame const& frame)
{
    std::vector<float> depths;
    for (std::size_t i = 0; i < frame.depth.values.size(); ++i)
        if (frame.alpha.values[i] > 0.5f) depths.push_back(frame.depth.values[i]);
    if (depths.empty()) throw Error("the first view shows nothing of the map (no pixel is half covered); choose another camera or trajectory");
    std::nth_element(depths.begin(), depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2), depths.end());
    return double{depths[depths.size() / 2]};
}

/// Seen from above: x to the right, z forward.
std::string paths(std::vector<scene::StampedPose> const& estimated, std::vector<scene::StampedPose> const& truth)
{
    report::Plot plot{"camera path, seen from above", {"x (world units)"}, {"z (world units)"}, {}};
    for (auto const& [name, poses] : {std::pair{"truth", &truth}, std::pair{"estimated", &estimated}}) {
        report::PlotSeries series{name, {}};
        series.colour = static_cast<std::uint32_t>(plot.series.size());
        for (auto const& p : *poses) series.points.emplace_back(p.pose.position.x, p.pose.position.z);
        plot.series.push_back(series);
    }
    return report::svg(plot);
}

int run(Options const& o)
{
    auto const map = o.map ? scene::load_map(*o.map) : scene::built_in_map();
    auto camera = o.map ? scene::frame_whole(map, o.size) : scene::built_in_camera(o.size);
    if (o.cameras) camera = scene::resized(scene::select_cameras(scene::load_cameras(*o.cameras), o.camera, o.map ? o.map->stem().string() : "built-in").front().camera, o.size.width, o.size.height);
    auto const lens = scene::lens_of(camera);
    auto const poses = poses_of(o, scene::pose_of(camera));
    std::error_code refused;
    std::filesystem::create_directories(o.out, refused);
    if (refused) throw Error("--out cannot be " + o.out.string() + " (" + refused.message() + "); name a folder");

    tilemesh::BasicRenderer<splat::Referenced<WithPlanes>> renderer{map, {.threads = o.threads}};
    track::PoseEvaluator evaluate{map, {o.size.width, o.size.height}, {.threads = o.threads}};
    evaluate.options().with_depth = o.depth;
    evaluate.options().with_exposure = o.noise > 0.0;
    track::Spoiling spoiling;
    spoiling.noise = o.noise;
    if (!(o.noise > 0.0)) spoiling = {0.0, false, 0.0, 0.0, 0.0, 0.0, 1};

    std::vector<track::Tracker> tracker;
    std::vector<scene::StampedPose> estimated, truth;
    std::vector<scene::Pose> estimates, truths;
    std::string frames;
    double scale = 1.0, all_ms = 0.0;
    std::size_t lost = 0;
    for (std::size_t k = 0; k < poses.size(); ++k) {
        auto const seen = scene::make_camera(poses[k].pose, lens);
        auto target = renderer.render(seen);
        if (k == 0) {
            scale = median_depth(target);
            evaluate.options().scene_depth = static_cast<float>(scale);
            track::TrackerOptions options;
            options.method = o.method;
            options.rows_per_pixel = o.depth ? 4.0 : 3.0;
            tracker.emplace_back(lens, scale, scene::pose_of(seen), options);
        }
        for (std::size_t i = 0; i < target.depth.values.size(); ++i) // no sensor measures what is half covered
            if (target.alpha.values[i] < 0.5f) target.depth.values[i] = 0.0f;
        track::spoil(target.image, target.depth, k, spoiling, o.threads);
        auto const picture = target.image;
        auto const begin = std::chrono::steady_clock::now();
        evaluate.set_target({std::move(target.image), o.depth ? std::move(target.depth) : report::Plane{}});
        auto const f = tracker.front().track(evaluate);
        double const ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
        all_ms += ms;
        lost += f.verdict == track::Verdict::lost;
        truths.push_back(scene::pose_of(seen));
        estimates.push_back(f.pose);
        truth.push_back({poses[k].seconds, truths.back()});
        estimated.push_back({poses[k].seconds, f.pose});
        double const degrees = glm::length(track::twist_between(truths.back(), f.pose).phi) * 180.0 / 3.14159265358979323846, off = glm::length(f.pose.position - truths.back().position);
        if (!o.quiet)
            std::cout << "frame " << k << ": " << track::name_of(f.verdict) << (f.why.empty() ? "" : ", ") << f.why << ", " << f.solution.evaluations << " evaluations, " << ms << " ms, off by " << degrees << " degrees and " << off << "\n";
        frames += std::string(k == 0 ? "" : ",\n") + "    {\"status\": \"" + track::name_of(f.verdict) + "\", \"iterations\": " + std::to_string(f.solution.evaluations) + ", \"host_ms\": " + number(ms) +
                  ", \"rotation_error_deg\": " + number(degrees) + ", \"translation_error\": " + number(off) + "}";
        if (k + 1 == poses.size()) report::write_ppm(o.out / "residual.ppm", report::error_picture(renderer.render(scene::make_camera(f.pose, lens)).image, picture));
    }
    auto const e = track::trajectory_errors(estimates, truths);
    report::write_whole(o.out / "estimated.tum", scene::tum_text(estimated));
    report::write_whole(o.out / "truth.tum", scene::tum_text(truth));
    report::write_whole(o.out / "paths.svg", paths(estimated, truth));
    double const each_ms = all_ms / static_cast<double>(poses.size());
    if (o.report)
        report::write_whole(*o.report, "{\n  \"frames\": [\n" + frames + "\n  ],\n  \"summary\": {\"ate_rmse\": " + number(e.ate.rmse) + ", \"ate_aligned_rmse\": " + number(e.ate_aligned.rmse) +
                                           ", \"rpe_rmse\": " + number(e.rpe.rmse) + ", \"rpe_deg_rmse\": " + number(e.rpe_deg.rmse) + ", \"median_depth\": " + number(scale) +
                                           ", \"frames_lost\": " + std::to_string(lost) + ", \"host_ms_per_frame\": " + number(each_ms) + "}\n}\n");
    if (!o.quiet)
        std::cout << poses.size() << " frames, " << lost << " lost; ATE " << e.ate.rmse << " (aligned " << e.ate_aligned.rmse << "), RPE " << e.rpe.rmse << " and " << e.rpe_deg.rmse << " degrees a frame; median depth " << scale << "; " << each_ms << " ms a frame\n";
    return 0;
}

} // namespace

int main(int argc, char** argv)
try {
    auto const options = track_camera::options_of(argc, argv);
    return options ? run(*options) : 0;
} catch (std::bad_alloc const&) {
    std::cerr << "out of memory (the system refused it); choose a smaller --size or map\n";
    return 2;
} catch (std::exception const& error) {
    std::cerr << error.what() << '\n';
    return 2;
}
