#pragma once
#include "frame_writer.hpp"
#include "options.hpp"
#include <cstdint>
#include <functional>
#include <string>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/rules.hpp>

namespace render_map {

/// Renders a view of the map on a mesh whose alpha plane is the bound (splat/bounded.hpp).
/// It begins on tiles that fit in Mk2, and takes larger ones once a frame needs them.
struct BoundFrame {
    tilemesh::RenderedFrame frame;
    std::uint32_t slots; ///< of a tile
    bool fits;           ///< in Mk2
};
using BoundRenderer = std::function<BoundFrame(tilemesh::splat::Camera const&, tilemesh::splat::Rules const&)>;
/// The map must live as long as the renderer.
BoundRenderer make_bound_renderer(tilemesh::scene::Map const& map, unsigned threads);

/// Writes the bound of a frame's picture, and returns a line about it. `frames`: of the run.
std::string bound(Options const& options, BoundRenderer const& renderer, tilemesh::splat::Camera const& camera, tilemesh::splat::Rules const& rules,
                  std::size_t frames, Frame const& frame);

} // namespace render_map
