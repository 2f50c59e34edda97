#include "renderer_of.hpp"
#include "setups.hpp"

std::unique_ptr<render_map::AnyRenderer> render_map::fitted_test(tilemesh::scene::Map const& map,
                                                                 tilemesh::scene::Demand const& demand,
                                                                 tilemesh::RendererOptions const& options)
{
    return fitted<tilemesh::splat::Roomy>(map, demand, options);
}
