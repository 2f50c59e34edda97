#include "exact_rays.hpp"
#include <algorithm>
#include <cstdint>
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/splat/exact.hpp>
#include <utility>

namespace {

template <std::uint32_t Degree>
struct OnRoomyTiles : tilemesh::splat::ExactOf<Degree> {
    using Machine = tilemesh::splat::RoomyMachine;
};

template <std::uint32_t Degree>
std::unique_ptr<tilemesh::render::Core> core_of(bool roomy, tilemesh::scene::Map map, tilemesh::RendererOptions options)
{
    if (!roomy) return std::make_unique<tilemesh::BasicRenderer<tilemesh::splat::ExactOf<Degree>>>(std::move(map), options);
    options.sizes = OnRoomyTiles<Degree>::sizes;
    options.sizes->storage = std::max(20'000u, static_cast<std::uint32_t>(map.gaussians.size() / 12)); // as --bound has them
    return std::make_unique<tilemesh::BasicRenderer<OnRoomyTiles<Degree>>>(std::move(map), options);
}

} // namespace

std::unique_ptr<tilemesh::render::Core> render_map::make_exact_rays(Choice const& choice, tilemesh::scene::Map map, tilemesh::RendererOptions options)
{
    bool const roomy = choice.machine == MachineKind::test, plain = map.sh_degree == 0;
    options.program = tilemesh::report::Program::anchored;
    return plain ? core_of<0>(roomy, std::move(map), options) : core_of<3>(roomy, std::move(map), options);
}
