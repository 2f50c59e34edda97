#include "renderer_of.hpp"
#include "setups.hpp"

std::unique_ptr<render_map::AnyRenderer>
render_map::lossless_mk2_threads(Choice const& choice, tilemesh::scene::Map const& map,
                                 tilemesh::RendererOptions const& options)
{
    return renderer_with_policies<tilemesh::splat::Lossless, tilemesh::Mesh>(choice, map, options);
}
