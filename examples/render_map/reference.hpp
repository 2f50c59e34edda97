#pragma once
#include <tilemesh/report/enclosure.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/rules.hpp>

namespace render_map {

/// The double-precision reference of the whole map, including records that the renderer left out.
tilemesh::report::Image reference_of(tilemesh::scene::Map const& map, tilemesh::splat::Camera const& camera,
                                     tilemesh::splat::Rules const& rules, tilemesh::report::Cuts cuts, unsigned threads);

/// The enclosure of the whole map's picture; of it, the least and the greatest value of each channel, rounded outward.
tilemesh::report::Enclosure enclosure_of(tilemesh::scene::Map const& map, tilemesh::splat::Camera const& camera,
                                         tilemesh::splat::Rules const& rules, unsigned threads);
tilemesh::report::Image bound_of(tilemesh::report::Enclosure const& enclosure, bool upper);

} // namespace render_map
