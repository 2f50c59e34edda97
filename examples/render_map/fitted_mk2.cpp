#include "renderer_of.hpp"
#include "setups.hpp"

namespace {
template <class S>
using OnMk2 = S;
} // namespace

std::unique_ptr<render_map::AnyRenderer> render_map::fitted_mk2(tilemesh::scene::Map const& map,
                                                                tilemesh::scene::Demand const& demand,
                                                                tilemesh::RendererOptions const& options)
{
    return fitted<OnMk2>(map, demand, options);
}
