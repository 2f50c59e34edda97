#pragma once
#include "../mapping/support.hpp"
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
inline tilemesh::mapping::Seen seen_from(tilemesh::slam::Mapper& truth, scene::Pose const& at)
{
    return truth.render(scene::make_camera(at, slam::lens()));
}
/// Keyframes 0 to n - 1: every fourth pose of the motion, and what is seen there.
inline support::mapping::Views keyframes(std::size_t n)
{
    tilemesh::slam::Mapper truth(wall(), 2);
    support::mapping::Views out;
    for (std::size_t k = 0; k < n; ++k) {
        out.cameras.push_back(scene::make_camera(pose(4 * k), slam::lens()));
        auto const seen = truth.render(out.cameras.back());
        out.targets.push_back(tilemesh::mapping::make_target(seen.colour, seen.depth));
    }
    return out;
}
/// What `Mapper::add` does at keyframe k, on a mesh that grows; at the second one, records move to the tiles of its view. Returns how many
/// Gaussians came and went.
template <class MeshRefiner>
std::array<std::size_t, 2> add_keyframe(MeshRefiner& mesh, support::mapping::Views const& views, std::size_t k,
                                        tilemesh::slam::MapperOptions const& m, float depth)
{
    auto const grown = mesh.insert(views.cameras[k], views.targets[k], static_cast<std::uint32_t>(k + 1));
    CHECK(grown.refused == 0);
    if (k == 1) mesh.rest(views.cameras[k]);
    auto const rates = splat::map::usual_rates(depth) * m.rate;
    auto const steps = k == 0 ? m.first_steps : m.steps;
    for (std::uint32_t i = 0; i < steps; ++i) {
        auto const by = tilemesh::slam::keyframe_of_step(k, i, m.window, m.seed);
        mesh.step(views.cameras[by], views.targets[by], splat::map::faded(rates, static_cast<float>(i) / static_cast<float>(steps)));
        CHECK(mesh.lost().records + mesh.lost().copies == 0);
    }
    return {grown.inserted, mesh.remove(depth)};
}

} // namespace support::slam
