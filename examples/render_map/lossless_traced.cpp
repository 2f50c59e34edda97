#include "setups.hpp"
#include "traced.hpp"

std::unique_ptr<render_map::AnyRenderer> render_map::lossless_traced(Choice const&, tilemesh::scene::Map const& map,
                                                                     tilemesh::RendererOptions const& options)
{
    return std::make_unique<TracedRendererOf<OnTraced<tilemesh::splat::Lossless>>>(map, options);
}
