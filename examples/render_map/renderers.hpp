#pragma once
#include "choice.hpp"
#include <memory>
#include <tilemesh/render/homes_layout.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/scene/map.hpp>

/// The renderers of one process. Machine, sizes, rules, planes, steps and degree of harmonics are values, and so are the engine and the
/// trace: there is one renderer a program.
namespace render_map {

std::unique_ptr<AnyRenderer> make_anchored(tilemesh::scene::Map map, tilemesh::render::Setup facts,
                                           tilemesh::RendererOptions const& options, EngineKind engine);
/// With a trace. The renderer is `Instruments`.
std::unique_ptr<AnyRenderer> make_anchored_traced(tilemesh::scene::Map map, tilemesh::render::Setup facts,
                                                  tilemesh::RendererOptions const& options, EngineKind engine);
/// The program of homes with a trace. The renderer is `Instruments`.
std::unique_ptr<AnyRenderer> make_homes_traced(tilemesh::scene::Map map, tilemesh::render::Setup const& choice,
                                               tilemesh::RendererOptions const& options, EngineKind engine);

} // namespace render_map
