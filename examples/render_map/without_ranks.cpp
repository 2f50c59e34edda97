#include "ranks.hpp"
#include <tilemesh/error.hpp>

// One process.
namespace render_map {

std::optional<int> ranks::begin(int&, char**&)
{
    return {};
}
int ranks::end(int status)
{
    return status;
}
std::uint32_t ranks::number() noexcept
{
    return 1;
}
std::uint32_t ranks::on_this_host() noexcept
{
    return 1;
}

namespace {
[[noreturn]] void refuse()
{
    throw tilemesh::Error("a renderer on several processes (this build has no MPI); build with -DTILEMESH_MPI=ON");
}
} // namespace

tilemesh::scene::Map ranks::load(Options const&, std::function<tilemesh::scene::Map()> const&)
{
    refuse();
}
std::uint64_t ranks::gaussians()
{
    refuse();
}
MapShape ranks::shape_of(std::string)
{
    refuse();
}
void ranks::at_degree(std::uint32_t)
{
    refuse();
}
tilemesh::scene::Demand ranks::demand_of(std::vector<tilemesh::splat::Camera> const&, tilemesh::splat::Rules const&, tilemesh::RendererOptions const&)
{
    refuse();
}
std::unique_ptr<tilemesh::render::Core> ranks::make(Choice const&, tilemesh::scene::Demand const&, tilemesh::RendererOptions const&)
{
    refuse();
}
std::unique_ptr<tilemesh::render::Core> ranks::make_homes(Choice const&, tilemesh::scene::Demand const&, tilemesh::RendererOptions const&)
{
    refuse();
}

} // namespace render_map
