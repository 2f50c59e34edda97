// A part of tilemesh::compiled: the program of homes on the engine that checks.
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/render/homes_renderer.hpp>

namespace tilemesh { inline namespace v0_2 {
using Program = render::HostHomesRenderer::Program;
template std::unique_ptr<engine::Port<Program>> make_checked_port(Program const&, Grid, MeshSizes<Program> const&, MeshOptions const&);
}} // namespace tilemesh
