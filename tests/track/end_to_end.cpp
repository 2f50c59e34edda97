// test: unoptimised test, without asan, cost 8
// Solver and tracker on the mesh's evaluator, over pictures of the built-in map.
#include "points.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/track/pose_evaluator.hpp>
#include <tilemesh/track/pose_solver.hpp>
#include <tilemesh/track/spoil.hpp>
#include <tilemesh/track/tracker.hpp>
#include <tilemesh/track/trajectory_error.hpp>

using namespace track_test;
using namespace tilemesh::track;

namespace {

constexpr Extent2 size{128, 96};
constexpr double scale = 1.6; // the map's median depth

/// A tenth of the built-in map's Gaussians, larger: small pictures have tiles of few pixels, and little room on each.
scene::Map thin_map()
{
    auto map = scene::built_in_map();
    std::vector<splat::Gaussian> few;
    for (std::size_t i = 0; i < map.gaussians.size(); i += 10) {
        few.push_back(map.gaussians[i]);
        for (float& s : few.back().log_scale) s += 0.7f;
    }
    map.gaussians = std::move(few);
    return map;
}
splat::Camera camera(int k)
{
    auto const first = scene::built_in_camera({size.width, size.height});
    return scene::make_camera(moved(scene::pose_of(first), {{0.01 * k, 0.0, 0.02 * k}, {0.005 * k, 0.01 * k, 0.0}}), scene::lens_of(first));
}
scene::Pose pose(int k)
{
    return scene::pose_of(camera(k));
}
/// What cameras 0 to n - 1 see.
std::vector<TrackTarget> targets_of(scene::Map const& map, int n, Spoiling const* spoiling)
{
    Renderer renderer(map, splat::with_planes(splat::lossless, true, true));
    std::vector<TrackTarget> out;
    for (int k = 0; k < n; ++k) {
        auto frame = renderer.render(camera(k));
        if (spoiling != nullptr) spoil(frame.image, frame.depth, static_cast<std::uint64_t>(k), *spoiling);
        out.push_back({std::move(frame.image), std::move(frame.depth)});
    }
    return out;
}

/// Tracks the targets as frames, from a start that is 0.6 degrees off.
template <class Evaluator>
std::vector<TrackedFrame> track_with(Evaluator&& evaluator, std::vector<TrackTarget> const& targets, std::uint32_t one_in)
{
    auto& o = evaluator.options();
    o.with_exposure = true;
    o.scene_depth = static_cast<float>(scale);
    o.one_in = one_in;
    Tracker tracker(scene::lens_of(camera(0)), scale, moved(pose(0), {{}, {0.0, 0.01, 0.0}}), {});
    std::vector<TrackedFrame> frames;
    for (std::size_t k = 0; k < targets.size(); ++k) {
        o.seed = static_cast<std::uint32_t>(k);
        evaluator.set_target(targets[k]);
        frames.push_back(tracker.track_at(evaluator, 0.03 * static_cast<double>(k), 1.0 / one_in));
    }
    return frames;
}

} // namespace

TEST_CASE("the solver finds the built-in map's camera from 1 degree and 1 % of the depth, to a hundredth of a degree")
{
    auto const map = thin_map();
    PoseEvaluator evaluator(map, size);
    evaluator.options().scene_depth = static_cast<float>(scale);
    evaluator.set_target(targets_of(map, 1, nullptr)[0]);
    Random random;
    for (auto const method : {Method::hybrid, Method::forward, Method::esm, Method::gradient}) {
        auto const start = disturbed(pose(0), 1.0, 0.01, random, scale);
        auto const s = solve_pose(evaluator, start, scene::lens_of(camera(0)), scale, stages_of(method, 4));
        INFO("method ", static_cast<int>(method), ", ", s.evaluations, " evaluations");
        CHECK(s.converged());
        CHECK(degrees_between(start.rotation, pose(0).rotation) == doctest::Approx(1.0));
        CHECK(degrees_between(s.pose.rotation, pose(0).rotation) < 1e-2);
        CHECK(glm::length(s.pose.position - pose(0).position) < 1e-3 * scale);
        CHECK(s.evaluations < 40);
    }
}

TEST_CASE("a short walk is tracked by colour alone, with noise, 8 bits and a gain that drifts; a picture of another map is lost")
{
    auto const map = thin_map();
    Spoiling spoiling;
    spoiling.gain_drift = 0.5; // over so few frames
    auto targets = targets_of(map, 5, &spoiling);
    for (auto& target : targets) target.depth = {};
    TrackerOptions options;
    options.method = Method::esm;
    Tracker tracker(scene::lens_of(camera(0)), scale, pose(0), options);
    PoseEvaluator evaluator(map, size);
    evaluator.options().with_exposure = true;
    evaluator.options().scene_depth = static_cast<float>(scale);
    std::vector<scene::Pose> truth, estimated;
    for (int k = 0; k < 5; ++k) {
        evaluator.set_target(targets[static_cast<std::size_t>(k)]);
        auto const f = tracker.track(evaluator);
        INFO(k, " ", f.why);
        CHECK(f.verdict == Verdict::converged);
        CHECK(f.exposure.log_gain == doctest::Approx(std::log(gain_of(spoiling, static_cast<std::uint64_t>(k)))).epsilon(0.02).scale(1.0));
        truth.push_back(pose(k));
        estimated.push_back(f.pose);
        // The error is as large as the covariance says: within five standard deviations of the worst motion.
        CHECK(degrees_between(f.pose.rotation, pose(k).rotation) < 5.0 * f.accuracy.worst_px / double{camera(0).fx} * 180.0 / 3.14159265358979);
    }
    auto const errors = trajectory_errors(estimated, truth);
    MESSAGE("ATE ", errors.ate.rmse / scale, " of the depth, ", errors.rotation_deg.rmse, " degrees");
    CHECK(errors.rotation_deg.rmse < 0.1);
    CHECK(errors.ate.rmse < 5e-3 * scale);

    std::reverse(targets[4].colour.rgb.begin(), targets[4].colour.rgb.end()); // upside down, mirrored, and red for blue
    evaluator.set_target(targets[4]);
    auto const f = tracker.track(evaluator);
    CHECK(f.verdict == Verdict::lost);
    CHECK(f.pose.position == f.start.position);
}

TEST_CASE("a walk by a rolling shutter is tracked as one without, if the tracker knows the time of its rows")
{
    auto const map = thin_map();
    int const n = 5;
    double const readout = 0.8; // of a frame's time
    scene::Trajectory path;
    for (int k = 0; k < n; ++k) path.push_back({static_cast<double>(k), pose(k)});
    Renderer renderer(map, splat::with_planes(splat::lossless, true, true));
    std::vector<TrackTarget> targets;
    for (int k = 0; k < n; ++k) {
        auto seen = camera(k);
        if (k > 0) seen.shutter = scene::shutter_at(path, static_cast<std::size_t>(k), readout, scene::lens_of(seen)); // the first stands still
        auto frame = renderer.render(seen);
        targets.push_back({std::move(frame.image), std::move(frame.depth)});
    }
    auto const error = [&](double known) {
        TrackerOptions options;
        options.readout = known;
        Tracker tracker(scene::lens_of(camera(0)), scale, pose(0), options);
        PoseEvaluator evaluator(map, size);
        evaluator.options().scene_depth = static_cast<float>(scale);
        std::vector<scene::Pose> truth, estimated;
        for (int k = 0; k < n; ++k) {
            evaluator.set_target(targets[static_cast<std::size_t>(k)]);
            auto const f = tracker.track(evaluator);
            INFO(k, " ", f.why);
            CHECK((known == 0 || f.verdict == Verdict::converged)); // without, frames may be lost
            CHECK(f.shutter.rolls() == (known > 0 && k > 0));
            truth.push_back(pose(k)), estimated.push_back(f.pose);
        }
        auto const errors = trajectory_errors(estimated, truth);
        MESSAGE("readout ", known, ": ATE ", errors.ate.rmse / scale, " of the depth, ", errors.rotation_deg.rmse, " degrees");
        return std::pair{errors.ate.rmse / scale, errors.rotation_deg.rmse};
    };
    auto const without = error(0), with = error(readout);
    CHECK(4 * with.first < without.first);
    CHECK(4 * with.second < without.second);
    CHECK(with.first < 1e-3);

    // A stamp that says that the camera turned by radians while it read a frame: such a shutter is left out.
    TrackerOptions options;
    options.readout = readout;
    Tracker tracker(scene::lens_of(camera(0)), scale, pose(0), options);
    PoseEvaluator evaluator(map, size);
    evaluator.options().scene_depth = static_cast<float>(scale);
    for (int k = 0; k < 2; ++k) {
        evaluator.set_target(targets[static_cast<std::size_t>(k)]);
        CHECK_FALSE(tracker.track(evaluator, k == 0 ? 1.0 : 1e-3).shutter.rolls());
    }
}

TEST_CASE("tracked poses have equal bits over tile sizes, threads and engines, with all blocks and with a part of them")
{
    auto const map = thin_map();
    Spoiling const spoiling;
    auto const targets = targets_of(map, 3, &spoiling);
    using Checked = BasicPoseEvaluator<TrackedByReference<splat::Lossless>, CheckedMesh>;
    for (std::uint32_t const one_in : {1u, 3u}) {
        auto const expected = track_with(PoseEvaluator(map, size, {1, {8, 8}}), targets, one_in);
        for (std::size_t k = 0; k < expected.size(); ++k) {
            INFO("one block in ", one_in, ": ", expected[k].why);
            CHECK(expected[k].verdict == Verdict::converged);
            CHECK(std::fabs(twist_between(pose(static_cast<int>(k)), expected[k].pose).phi.y) < 2e-3);
        }
        for (auto const& frames :
             {track_with(PoseEvaluator(map, size, {2, {16, 16}}), targets, one_in),
              track_with(PoseEvaluator(map, size, {3, {8, 24}}), targets, one_in), track_with(Checked(map, size, {1, {16, 8}}), targets, one_in)})
            for (std::size_t k = 0; k < targets.size(); ++k) {
                auto const &a = frames[k], &b = expected[k];
                CHECK(std::memcmp(&a.pose.rotation, &b.pose.rotation, sizeof a.pose.rotation) == 0);
                CHECK(std::memcmp(&a.pose.position, &b.pose.position, sizeof a.pose.position) == 0);
                CHECK(a.exposure.log_gain == b.exposure.log_gain);
                CHECK(a.exposure.offset == b.exposure.offset);
                CHECK(a.solution.evaluations == b.solution.evaluations);
                CHECK(a.verdict == b.verdict);
                CHECK(a.accuracy.worst_px == b.accuracy.worst_px);
            }
    }
}
