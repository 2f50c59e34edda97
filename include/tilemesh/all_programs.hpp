#pragma once
#include <memory>
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/render/homes_renderer.hpp>
#include <tilemesh/renderer.hpp>
#include <utility>

/// All programs and engines of a Renderer: anchored and homes, on host threads and on the engine that checks, with a trace or without. With
/// headers alone, one source file of the program defines TILEMESH_ALL_PROGRAMS before its first include, and includes this header or
/// tilemesh.hpp. A program that links tilemesh::compiled has all.
namespace tilemesh { inline namespace v0_2 { namespace render {

/// Makes core `R`, whose mesh is a PortMesh.
template <class R>
std::unique_ptr<Core> make_on_port(scene::Map map, Setup const& setup, RendererOptions const& options)
{
    typename R::EngineOptions engine;
    engine.trace = options.trace;
    if (options.engine == EngineKind::checked) engine.make = make_checked_port<typename R::Program>;
    return std::make_unique<R>(std::move(map), setup, options, std::move(engine));
}

/// Makes any core of a Renderer. It is a template, so that only who calls it compiles all of them.
template <class Homes = HostHomesRenderer>
std::unique_ptr<Core> make_any_core(scene::Map map, Setup const& setup, RendererOptions const& options)
{
    return setup.program == splat::Program::homes ? make_on_port<Homes>(std::move(map), setup, options)
                                                  : make_on_port<HostRenderer>(std::move(map), setup, options);
}

#if defined(TILEMESH_ALL_PROGRAMS) && !defined(TILEMESH_COMPILED)
/// Tells Renderer, before `main`.
inline bool const has_all_programs = (make_other_core = make_any_core<>) != nullptr;
#endif

}}} // namespace tilemesh::render
