#include "renderer_of.hpp"
#include "setups.hpp"

std::unique_ptr<render_map::AnyRenderer>
render_map::paper_mk2_sequential(Choice const& choice, tilemesh::scene::Map const& map,
                                 tilemesh::RendererOptions const& options)
{
    return renderer_with_policies<tilemesh::splat::Paper, tilemesh::CheckedMesh>(choice, map, options);
}
