#include "renderer_of.hpp"
#include "setups.hpp"

std::unique_ptr<render_map::AnyRenderer>
render_map::lossless_test_sequential(Choice const& choice, tilemesh::scene::Map const& map,
                                     tilemesh::RendererOptions const& options)
{
    return renderer_with_policies<tilemesh::splat::Roomy<tilemesh::splat::Lossless>, tilemesh::CheckedMesh>(choice, map, options);
}
