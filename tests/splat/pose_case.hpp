#pragma once
#include "support.hpp"
#include <tilemesh/track/pose_evaluator.hpp>

/// A map and a picture for tests that compare the sums of one evaluation of a pose on two engines.
namespace support::pose {

struct SumsCase {
    scene::Map map;
    splat::Camera camera;
    track::TrackTarget target;
};

/// A cloud that covers most pixels, and a picture that it does not explain: residuals on both sides of Huber's widths, holes in the depth,
/// pixels that do not count.
inline SumsCase sums_case(std::uint32_t width, std::uint32_t height, std::uint32_t n, std::uint64_t seed)
{
    auto gaussians = cloud(n, seed);
    for (auto& g : gaussians) {
        for (float& s : g.log_scale) s = std::min(s + 2.0f, -1.2f);
        g.opacity = std::max(g.opacity, 0.3f);
    }
    SumsCase c{map_of(std::move(gaussians)), lens(width, height, 0.02f), {report::Image(width, height), report::Plane(width, height)}};
    Random random(seed);
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x) {
            for (int k = 0; k < 3; ++k) c.target.colour.pixel(x, y)[k] = random.uniform(0, 1);
            c.target.depth.at(x, y) = random.below(9) == 0 ? 0.0f : random.uniform(1.5f, 3.0f);
            if (random.below(50) == 0) c.target.colour.pixel(x, y)[1] = std::numeric_limits<float>::quiet_NaN();
        }
    return c;
}
inline bool same_sums(track::NormalEquations const& a, track::NormalEquations const& b)
{
    return a.unknowns == b.unknowns && a.pixels == b.pixels && a.cost == b.cost && std::memcmp(a.h, b.h, sizeof a.h) == 0 &&
           std::memcmp(a.g, b.g, sizeof a.g) == 0;
}
/// The options of a case: Jacobian, cells, exposure, depth and subsets of blocks in turn, so that few evaluations meet all of them.
inline track::TrackOptions sums_options(track::Jacobian jacobian, std::uint32_t cell)
{
    track::TrackOptions o;
    o.level = {cell, jacobian, {0.1, 0.01}};
    o.with_exposure = cell != 2;
    o.with_depth = cell != 4;
    o.one_in = cell == 2 ? 2 : 1;
    o.scene_depth = 2.5f;
    return o;
}

} // namespace support::pose
