#include "machine.hpp"
#include "setups.hpp"
#include <tilemesh/render/frame_renderer.hpp>

namespace channel_capacity {

namespace {

template <class S>
tilemesh::render::Setup with_room()
{
    auto setup = tilemesh::splat::setup_of<S>();
    setup.machine = tilemesh::size_of_machine<splat::RoomyMachine>();
    setup.sizes = Budget<S>::split(most_slots, Budget<S>::storage_slots(1));
    return setup;
}

} // namespace

std::unique_ptr<Machine> make_machine(Saturation s, scene::Map const& map, Limits limits)
{
    return bench::make_traced_machine(map, s == Saturation::hold ? with_room<Held>() : with_room<Dropped>(),
                                      {.grid = {grid_columns, grid_rows}, .hops = limits.hops, .storage_slots = limits.storage_slots});
}

} // namespace channel_capacity
