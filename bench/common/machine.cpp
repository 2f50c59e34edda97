#include "machine_over.hpp"
#include <tilemesh/renderer.hpp>

std::unique_ptr<bench::Machine> bench::make_machine(tilemesh::scene::Map const& map, tilemesh::render::Setup const& setup,
                                                    tilemesh::RendererOptions const& options)
{
    return std::make_unique<MachineOver<Machine, tilemesh::Renderer::Core>>(map, setup, options);
}
