#include "host_renderer.hpp"
#include "traced.hpp"
#include <tilemesh/engine/checked_mesh.hpp>

render_map::MakeRenderer& render_map::sequential_planes_traced =
    make<TracedRenderer<HostRenderer<tilemesh::CheckedMesh, tilemesh::Traced<tilemesh::AnyMachine>, true>>>;
