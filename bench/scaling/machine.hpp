#pragma once
#include <common/machine.hpp>
#include <memory>
#include <tilemesh/renderer.hpp>

namespace scaling {

/// A mesh with room on every tile for what any value of any axis brings.
std::unique_ptr<bench::Machine> make_machine(tilemesh::scene::Map const&, tilemesh::RendererOptions const&);

} // namespace scaling
