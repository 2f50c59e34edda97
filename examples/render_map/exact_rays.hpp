#pragma once
#include "choice.hpp"
#include <memory>
#include <tilemesh/render/core.hpp>
#include <tilemesh/scene/map.hpp>

namespace render_map {

/// The renderer of exact rays (splat/exact.hpp). On machine `test`, tiles have room for a twelfth of the map.
std::unique_ptr<tilemesh::render::Core> make_exact_rays(Choice const& choice, tilemesh::scene::Map map, tilemesh::RendererOptions options);

} // namespace render_map
