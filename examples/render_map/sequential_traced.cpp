#include "host_renderer.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include "traced.hpp"

std::unique_ptr<render_map::AnyRenderer> render_map::sequential_traced(tilemesh::scene::Map const& map, tilemesh::render::SetupFacts facts,
                                                        tilemesh::RendererOptions const& options)
{
    using Machine = tilemesh::Traced<tilemesh::AnyMachine>;
    return std::make_unique<TracedRenderer<HostRenderer<tilemesh::CheckedMesh, Machine, false>>>(map, std::move(facts), options);
}
