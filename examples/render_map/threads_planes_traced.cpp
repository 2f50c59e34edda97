#include "host_renderer.hpp"

#include "traced.hpp"

std::unique_ptr<render_map::AnyRenderer> render_map::threads_planes_traced(tilemesh::scene::Map const& map, tilemesh::render::SetupFacts facts,
                                                        tilemesh::RendererOptions const& options)
{
    using Machine = tilemesh::Traced<tilemesh::AnyMachine>;
    return std::make_unique<TracedRenderer<HostRenderer<tilemesh::Mesh, Machine, true>>>(map, std::move(facts), options);
}
