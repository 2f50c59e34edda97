#pragma once
#include "../splat/support.hpp"
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/mapping/refiner.hpp>

namespace support::mapping {

using namespace tilemesh;
using tilemesh::mapping::Target;

/// The map with every parameter a little off.
inline scene::Map spoilt(scene::Map map, float scene_depth, std::uint64_t seed, float share = 1)
{
    Random random(seed);
    auto const normal = [&] { return share * std::sqrt(-2 * std::log(random.uniform(1e-6f,
        1))) * std::cos(6.2831853f * random.uniform(0, 1)); };
    for (auto& g : map.gaussians) {
        for (int i = 0; i < 3; ++i) {
            g.mean_world[i] += 0.005f * scene_depth * normal();
            g.log_scale[i] += 0.3f * normal();
            g.colour[i] = std::max(0.0f, g.colour[i] + 0.1f * normal());
        }
        for (float& q : g.rotation) q += 0.1f * normal();
        float const opacity = std::clamp(g.opacity, 1e-4f, 0.9999f);
        g.opacity = 1 / (1 + (1 - opacity) / opacity * std::exp(0.5f * normal()));
    }
    return map;
}
/// The median of the known depths.
inline float median_depth(Target const& target)
{
    std::vector<float> depths;
    for (auto const& p : target.pixels)
        if (p.depth > 0) depths.push_back(p.depth);
    std::nth_element(depths.begin(), depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2), depths.end());
    return depths[depths.size() / 2];
}
struct Views {
    std::vector<splat::Camera> cameras;
    std::vector<Target> targets;
};
inline Views views_of(scene::Map const& truth, std::vector<splat::Camera> cameras)
{
    tilemesh::mapping::Refiner<> renderer(truth);
    Views out{std::move(cameras), {}};
    for (auto const& c : out.cameras) {
        auto const seen = renderer.render(c);
        out.targets.push_back(tilemesh::mapping::make_target(seen.colour, seen.depth));
    }
    return out;
}
template <class Refiner>
double mean_psnr(Refiner& refiner, Views const& views)
{
    double sum = 0;
    for (std::size_t i = 0; i < views.cameras.size(); ++i) sum += refiner.measure(views.cameras[i], views.targets[i]).psnr_db();
    return sum / double(views.cameras.size());
}
/// The messages of a kernel's steps in the last run.
inline std::uint64_t messages_of(RunCounters const& run, std::string const& kernel)
{
    std::uint64_t n = 0;
    for (auto const& s : run.steps) n += s.kernel == kernel ? s.messages : 0;
    return n;
}

} // namespace support::mapping
