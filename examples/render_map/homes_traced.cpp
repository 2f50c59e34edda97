#include "renderers.hpp"
#include "traced_homes.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <utility>

std::unique_ptr<render_map::AnyRenderer> render_map::make_homes_traced(tilemesh::scene::Map map,
                                                                       tilemesh::render::Setup const& choice,
                                                                       tilemesh::RendererOptions const& options, EngineKind kind)
{
    TracedHomes::EngineOptions engine;
    engine.trace = true;
    if (kind == EngineKind::sequential) engine.make = tilemesh::make_checked_port<TracedHomes::Program>;
    return std::make_unique<TracedHomes>(std::move(map), choice, options, engine);
}
