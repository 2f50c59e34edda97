// A part of tilemesh::compiled: the program of homes on host threads.
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/render/homes_renderer.hpp>

namespace tilemesh { inline namespace v0_2 {
using Program = render::HostHomesRenderer::Program;
template std::unique_ptr<engine::Port<Program>> make_threads_port(Program const&, Grid, MeshSizes<Program> const&, MeshOptions const&);
}} // namespace tilemesh
