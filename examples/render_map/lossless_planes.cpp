#include "renderer_of.hpp"
#include "setups.hpp"

std::unique_ptr<render_map::AnyRenderer> render_map::lossless_planes(Choice const& choice, tilemesh::scene::Map const& map,
                                                                     tilemesh::RendererOptions const& options)
{
    return renderer_with_planes<tilemesh::splat::Lossless>(choice, map, options);
}
