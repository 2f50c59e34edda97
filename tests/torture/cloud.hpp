#pragma once
#include "../splat/support.hpp"
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/orbit.hpp>

// The map that is rendered while memory runs out.
namespace torture {
using namespace tilemesh;

/// 60 Gaussians in a cloud.
inline scene::Map const& cloud()
{
    static scene::Map const map = [] {
        scene::Map made;
        made.name = "cloud";
        support::Random random(7);
        for (std::uint32_t i = 0; i < 60; ++i) {
            splat::Gaussian g{};
            g.id = splat::GaussianId{i + 1};
            for (float& x : g.mean_world) x = random.uniform(-1, 1);
            for (float& c : g.colour) c = random.uniform(0, 1);
            for (float& s : g.log_scale) s = random.uniform(-3.5f, -1.5f);
            g.rotation[0] = 1;
            g.opacity = random.uniform(0.3f, 1);
            made.gaussians.push_back(g);
        }
        return made;
    }();
    return map;
}
inline std::vector<splat::Camera> const& views()
{
    static auto const cameras = scene::orbit(scene::frame_whole(cloud(), {60, 40}), scene::robust_centre(cloud()), 25, 3);
    return cameras;
}
inline RendererOptions options(std::uint32_t threads = 1)
{
    RendererOptions o;
    o.threads = threads;
    o.grid = {4, 3};
    return o;
}

/// The machine keeps a trace.
struct Watched : splat::Lossless {
    using Machine = Traced<Mk2>;
};
using WatchedRenderer = BasicRenderer<splat::Referenced<Watched>>;

} // namespace torture
