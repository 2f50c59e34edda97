#pragma once
#include "choice.hpp"
#include <memory>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup_facts.hpp>
#include <tilemesh/scene/map.hpp>

/// One function for each compiled renderer, each in its own .cpp. Machine, sizes, saturation, copies, colour format and degree of harmonics
/// are values, so they need no renderer of their own.
namespace render_map {

using MakeRenderer = std::unique_ptr<AnyRenderer>(tilemesh::scene::Map const&, tilemesh::render::SetupFacts,
                                                  tilemesh::RendererOptions const&);
extern MakeRenderer &threads, &threads_planes, &threads_traced, &threads_planes_traced; ///< the traced ones are `Instruments`
extern MakeRenderer &sequential, &sequential_planes, &sequential_traced, &sequential_planes_traced;
extern MakeRenderer& threads_placed;          ///< without routing: the host places the records of a static view
extern MakeRenderer& threads_placed_unspread; ///< without routing and bloom: no footprint touches two tiles

using MakeHomesRenderer = std::unique_ptr<AnyRenderer>(tilemesh::scene::Map const&, tilemesh::render::HomesChoice const&,
                                                       tilemesh::RendererOptions const&);
/// The program of homes, with planes for any choice. Both are `Instruments`: sequentially, a trace beside the checks costs little.
extern MakeHomesRenderer &homes_traced, &homes_sequential;

} // namespace render_map
