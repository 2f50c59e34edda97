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
ranks::Parts& ranks::parts()
{
    throw tilemesh::Error("a renderer on several processes (this build has no MPI); build with -DTILEMESH_MPI=ON");
}

} // namespace render_map
