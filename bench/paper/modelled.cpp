#include "modelled.hpp"
#include "machines.hpp"
#include <algorithm>
#include <common/scenes.hpp>
#include <tilemesh/scene/records.hpp>
#include <utility>

paper::Modelled paper::model_scene(Context const& context, std::string const& name)
{
    auto loaded = bench::load_scene(name, context.data, {1280, 720});
    loaded.map = scene::at_degree(std::move(loaded.map), 0); // as in the paper
    Modelled m;
    m.gaussians = loaded.map.gaussians.size();
    m.frames = context.quick ? 2 : m.gaussians > 100'000 ? 4 : 12;
    Watched machine(loaded.map, {.threads = context.threads});
    auto const render = [&](splat::Camera const& camera) {
        auto const frame = machine.render(camera);
        m.complete = m.complete && frame.report.lost.empty();
        return frame.milliseconds;
    };
    m.first = render(loaded.camera);
    m.static_view = render(loaded.camera);
    auto const cameras = bench::cameras_of("orbit0.5", loaded, m.frames, context.data);
    for (std::uint32_t k = 1; k <= m.frames; ++k) {
        auto const ms = render(cameras[k]);
        m.milliseconds += ms / m.frames;
        m.least = k == 1 ? ms : std::min(m.least, ms);
        m.most = std::max(m.most, ms);
    }
    return m;
}
