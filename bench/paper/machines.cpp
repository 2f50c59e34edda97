#include "machines.hpp"
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/render/frame_renderer.hpp>

namespace paper {

namespace render = tilemesh::render;

Watched::Watched(scene::Map const& map, Options const& options)
{
    auto setup = splat::setup_of<splat::Lossless>();
    setup.machine = tilemesh::size_of_machine<splat::RoomyMachine>();
    setup.sizes.storage = options.storage_slots;
    setup.sizes.road = setup.sizes.beam = options.channel_slots;
    machine_ = bench::make_traced_machine(
        map, setup, {.threads = options.threads, .grid = {grid_columns, grid_rows}, .footprint = options.footprint});
}

ModelledFrame Watched::render(splat::Camera const& camera)
{
    static tilemesh::CostModel const model = tilemesh::mk2();
    machine_->render(camera);
    auto const cost = tilemesh::model_cost(model, machine_->trace(), machine_->grid());
    return {machine_->report(), tilemesh::milliseconds(model, cost.cycles)};
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

} // namespace paper
