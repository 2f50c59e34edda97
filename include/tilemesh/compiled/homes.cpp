// A part of tilemesh::compiled: the renderer of the program of homes, by reference, for all choices and all engines of one process.
#include <tilemesh/render/homes_renderer.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {
template class HomesRenderer<splat::homes::AnyHostPolicies, PortMesh, Traced<AnyMachine>>;
}}} // namespace tilemesh::render
