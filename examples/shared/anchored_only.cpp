// For a program that links few units of the compiled library (tilemesh_first): its Renderer has the anchored program on host threads.
#include <memory>
#include <tilemesh/error.hpp>
#include <tilemesh/renderer.hpp>

std::unique_ptr<tilemesh::render::Core> tilemesh::render::make_other_core(scene::Map, Setup const&, RendererOptions const&)
{
    throw Error("homes, or an engine that checks, in a program without them (it links tilemesh_first); link tilemesh::compiled");
}
