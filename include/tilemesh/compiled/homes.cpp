// A part of tilemesh::compiled: the program of homes, by reference, for all setups and all engines of one process, and what a Renderer has
// beside the anchored program on threads.
#include <tilemesh/all_programs.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace render {
template class HomesRenderer<splat::homes::AnyHostPolicies, PortMesh, Traced<AnyMachine>>;

std::unique_ptr<Core> make_other_core(scene::Map map, Setup const& setup, RendererOptions const& options)
{
    return make_any_core<>(std::move(map), setup, options);
}
}}} // namespace tilemesh::render
