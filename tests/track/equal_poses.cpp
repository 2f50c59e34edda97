// test: unoptimised test, without asan
#include "../standard.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/pose_evaluator.hpp>
#include <tilemesh/track/spoil.hpp>
#include <tilemesh/track/tracker.hpp>

using namespace tilemesh;
using namespace tilemesh::track;

namespace {

constexpr Extent2 size{128, 96};

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

/// Tracks the targets as three frames, from a start that is 0.6 degrees off.
template <class Evaluator>
std::vector<TrackedFrame> track_with(Evaluator&& evaluator, std::vector<TrackTarget> const& targets, std::uint32_t one_in)
{
    auto& o = evaluator.options();
    o.with_exposure = true;
    o.scene_depth = 1.6f;
    o.one_in = one_in;
    Tracker tracker(scene::lens_of(camera(0)), 1.6, moved(scene::pose_of(camera(0)), {{}, {0.0, 0.01, 0.0}}), {});
    std::vector<TrackedFrame> frames;
    for (std::size_t k = 0; k < targets.size(); ++k) {
        o.seed = static_cast<std::uint32_t>(k);
        evaluator.set_target(targets[k]);
        frames.push_back(tracker.track_at(evaluator, 0.03 * static_cast<double>(k), 1.0 / one_in));
    }
    return frames;
}

} // namespace

TEST_CASE("tracked poses have equal bits over tile sizes, threads and engines, with all blocks and with a part of them")
{
    auto const map = thin_map();
    std::vector<TrackTarget> targets;
    BasicRenderer<splat::Referenced<splat::WithPixel<splat::Lossless, splat::WithAlpha<splat::WithDepth<splat::FloatPixel>>>>> renderer(map);
    for (int k = 0; k < 3; ++k) {
        auto frame = renderer.render(camera(k));
        spoil(frame.image, frame.depth, static_cast<std::uint64_t>(k), {});
        targets.push_back({std::move(frame.image), std::move(frame.depth)});
    }
    using Checked = BasicPoseEvaluator<TrackedByReference<splat::Lossless>, CheckedMesh>;
    for (std::uint32_t const one_in : {1u, 3u}) {
        auto const expected = track_with(PoseEvaluator(map, size, {1, {8, 8}}), targets, one_in);
        for (std::size_t k = 0; k < expected.size(); ++k) {
            INFO("one block in ", one_in, ": ", expected[k].why);
            CHECK(expected[k].verdict == Verdict::converged);
            CHECK(std::fabs(twist_between(scene::pose_of(camera(static_cast<int>(k))), expected[k].pose).phi.y) < 2e-3);
        }
        for (auto const& frames : {track_with(PoseEvaluator(map, size, {2, {16, 16}}), targets, one_in), track_with(PoseEvaluator(map, size, {3, {8, 24}}), targets, one_in),
                                   track_with(Checked(map, size, {1, {16, 8}}), targets, one_in)})
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
