// A part of tilemesh::compiled: the anchored program on the engine that checks.
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/basic_renderer.hpp>

namespace tilemesh { inline namespace v0_2 {
using Program = render::HostRenderer::Program;
template std::unique_ptr<engine::Port<Program>> make_checked_port(Program const&, Grid, MeshSizes<Program> const&, MeshOptions const&);
}} // namespace tilemesh
