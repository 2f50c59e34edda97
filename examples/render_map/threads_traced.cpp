#include "host_renderer.hpp"
#include "traced.hpp"
#include <tilemesh/engine/mesh.hpp>

render_map::MakeRenderer& render_map::threads_traced =
    make<TracedRenderer<HostRenderer<tilemesh::Mesh, tilemesh::Traced<tilemesh::AnyMachine>, false>>>;
