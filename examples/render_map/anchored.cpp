#include "renderers.hpp"
#include "traced.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/fit_renderer.hpp>
#include <utility>

namespace {
using tilemesh::render::HostRenderer;

/// Makes a `Renderer` over the renderer of all setups.
template <class Renderer>
std::unique_ptr<render_map::AnyRenderer> make(tilemesh::scene::Map map, tilemesh::render::Setup facts,
                                              tilemesh::RendererOptions const& options, render_map::EngineKind kind, bool trace)
{
    HostRenderer::EngineOptions engine;
    if (kind == render_map::EngineKind::sequential) engine.make = tilemesh::make_checked_port<HostRenderer::Program>;
    engine.trace = trace;
    return std::make_unique<Renderer>(std::move(map), std::move(facts), options, engine);
}
} // namespace

std::unique_ptr<render_map::AnyRenderer> render_map::make_anchored(tilemesh::scene::Map map, tilemesh::render::Setup facts,
                                                                   tilemesh::RendererOptions const& options, EngineKind engine)
{
    return make<tilemesh::RendererOver<HostRenderer>>(std::move(map), std::move(facts), options, engine, false);
}
std::unique_ptr<render_map::AnyRenderer> render_map::make_anchored_traced(tilemesh::scene::Map map, tilemesh::render::Setup facts,
                                                                          tilemesh::RendererOptions const& options, EngineKind engine)
{
    return make<TracedRenderer<HostRenderer>>(std::move(map), std::move(facts), options, engine, true);
}
