#include "host_renderer.hpp"

std::unique_ptr<render_map::AnyRenderer> render_map::threads_placed(tilemesh::scene::Map const& map, tilemesh::render::SetupFacts facts,
                                                        tilemesh::RendererOptions const& options)
{
    using Machine = tilemesh::AnyMachine;
    return std::make_unique<tilemesh::RendererOver<HostRenderer<tilemesh::Mesh, Machine, false, false, true>>>(map, std::move(facts), options);
}
