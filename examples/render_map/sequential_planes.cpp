#include "host_renderer.hpp"
#include <tilemesh/engine/checked_mesh.hpp>

render_map::MakeRenderer& render_map::sequential_planes =
    make<tilemesh::RendererOver<HostRenderer<tilemesh::CheckedMesh, tilemesh::AnyMachine, true>>>;
