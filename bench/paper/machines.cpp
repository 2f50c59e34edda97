#include "machines.hpp"
#include <algorithm>
#include <common/scenes.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/scene/records.hpp>
#include <utility>

namespace paper {

std::unique_ptr<bench::Machine> make_watched(scene::Map const& map, Watched const& options)
{
    auto setup = splat::setup_of<splat::Lossless>();
    setup.machine = tilemesh::size_of_machine<splat::RoomyMachine>();
    setup.sizes.storage = options.storage_slots;
    setup.sizes.road = setup.sizes.beam = options.channel_slots;
    return bench::make_traced_machine(map, setup, {.threads = options.threads, .grid = {grid_columns, grid_rows}, .footprint = options.footprint});
}

PaperFrame render_paper(scene::Map const& map, splat::Camera const& camera, std::uint32_t channel_slots, std::uint32_t storage_slots,
                        std::uint32_t threads)
{
    auto setup = splat::setup_of<splat::Paper>();
    setup.sizes.road = setup.sizes.beam = channel_slots;
    setup.sizes.storage = storage_slots;
    setup.rules.arithmetic = splat::Arithmetic::precise; // because the picture is compared with the naive picture
    auto const machine = bench::make_machine(map, setup, {.threads = threads, .grid = {grid_columns, grid_rows}});
    machine->render(camera);
    return {machine->image(), machine->report(), setup.rules};
}

Modelled model_scene(Context const& context, std::string const& name)
{
    auto loaded = bench::load_scene(name, context.data, {1280, 720});
    loaded.map = scene::at_degree(std::move(loaded.map), 0); // as in the paper
    Modelled m;
    m.gaussians = loaded.map.gaussians.size();
    m.frames = context.quick ? 2 : m.gaussians > 100'000 ? 4 : 12;
    auto const machine = make_watched(loaded.map, {.threads = context.threads});
    auto const render = [&](splat::Camera const& camera) {
        machine->render(camera);
        m.complete = m.complete && machine->report().lost.empty();
        return bench::modelled_ms(machine->trace(), {grid_columns, grid_rows});
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

} // namespace paper
