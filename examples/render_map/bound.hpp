#pragma once
#include "frame_writer.hpp"
#include "options.hpp"
#include <functional>
#include <string>
#include <tilemesh/render/picture.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/rules.hpp>

namespace render_map {

/// Renders a view of the map on a mesh whose alpha plane is the bound (splat/bounded.hpp).
using BoundRenderer = std::function<tilemesh::RenderedFrame(tilemesh::splat::Camera const&, tilemesh::splat::Rules const&)>;
BoundRenderer make_bound_renderer(tilemesh::scene::Map const& map, unsigned threads);

/// Writes the bound of a frame's picture, and returns a line about it. `frames`: of the run.
std::string bound(Options const& options, BoundRenderer const& renderer, tilemesh::splat::Camera const& camera, tilemesh::splat::Rules const& rules,
                  std::size_t frames, Frame const& frame);

} // namespace render_map
