// A part of tilemesh::compiled: the renderer of the program of homes, by reference, for all choices and all engines of one process.
#include <tilemesh/render/homes_renderer.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace render {
template class HomesRenderer<splat::homes::AnyHostPolicies, PortMesh, Traced<AnyMachine>>;

template <>
std::unique_ptr<AnyRenderer> make_homes_renderer<splat::FloatPixel>(scene::Map map, Setup const& setup,
                                                                    RendererOptions const& options)
{
    return std::make_unique<HostHomesRenderer>(std::move(map), setup, options);
}
template <>
std::unique_ptr<AnyRenderer> make_homes_renderer<HomesPlanes>(scene::Map map, Setup const& setup, RendererOptions const& options)
{
    return std::make_unique<HostHomesRenderer>(std::move(map), setup, options);
}
}}} // namespace tilemesh::render
