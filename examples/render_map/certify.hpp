#pragma once
#include "frame_writer.hpp"
#include "options.hpp"
#include "photographs.hpp"
#include <cstddef>
#include <optional>
#include <string>
#include <tilemesh/report/enclosure.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/rules.hpp>

namespace render_map {

/// The least or the greatest value of each channel, rounded outward.
tilemesh::report::Image bound_of(tilemesh::report::Enclosure const& enclosure, bool upper);

/// Proves how far a frame is from the exact formula of the whole map, and why: in the frame's entry, and in the line that is returned. With
/// --compare, judges the other picture, too. With --float, writes the pictures of the bounds. `frames`: of the run.
std::string certify(Options const& options, tilemesh::scene::Map const& map, tilemesh::splat::Camera const& camera,
                    tilemesh::splat::Rules const& rules, std::size_t frames, Frame& frame, std::optional<OtherPicture> const& other);

} // namespace render_map
