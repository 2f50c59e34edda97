#pragma once
#include "../splat/support.hpp"
#include <tilemesh/mapping/view_sums.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/slam/mapper.hpp>
#include <tilemesh/track/pose_update.hpp>

namespace support::slam {

using namespace tilemesh;

/// A wall of Gaussians at depth 2 to 2.6 with strong colours, wider than the picture, and balls in front of it.
inline scene::Map wall(std::uint64_t seed = 3)
{
    Random random(seed);
    std::vector<splat::Gaussian> out;
    auto const add = [&](float x, float y, float z, float size) {
        auto g = ball(static_cast<std::uint32_t>(out.size() + 1), 0, 0, size, 0.95f);
        g.mean_world[0] = x, g.mean_world[1] = y, g.mean_world[2] = z;
        for (float& c : g.colour) c = random.uniform(0, 1);
        out.push_back(g);
    };
    for (int row = -9; row <= 9; ++row)
        for (int column = -14; column <= 14; ++column)
            add(0.2f * static_cast<float>(column), 0.2f * static_cast<float>(row),
                2.3f + 0.3f * std::sin(static_cast<float>(3 * row + column)), 0.1f);
    for (int i = 0; i < 30; ++i) add(random.uniform(-1.5f, 1.5f), random.uniform(-0.9f, 0.9f), random.uniform(1.4f, 1.9f), 0.06f);
    return map_of(std::move(out));
}
/// The k-th pose of a motion of about a degree and 1 % of the depth a frame.
inline scene::Pose pose(std::size_t k)
{
    double const t = static_cast<double>(k);
    return track::moved(scene::Pose{}, {{0.02 * std::sin(0.8 * t), 0.012 * t, 0.015 * std::sin(0.5 * t)},
                                        {0.01 * std::sin(0.7 * t), 0.012 * t, 0.004 * t}});
}
inline scene::Intrinsics lens(std::uint32_t width = 96, std::uint32_t height = 60)
{
    return scene::lens_of(support::lens(width, height));
}
/// What a camera with a sensor of depths sees of the map.
inline mapping::Seen seen_from(tilemesh::slam::Mapper& truth, scene::Pose const& at)
{
    return truth.render(scene::make_camera(at, slam::lens()));
}

} // namespace support::slam
