#include "host_renderer.hpp"
#include <tilemesh/engine/mesh.hpp>

render_map::MakeRenderer& render_map::threads =
    make<tilemesh::RendererOver<HostRenderer<tilemesh::Mesh, tilemesh::AnyMachine, false>>>;
