#pragma once
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/rules.hpp>

namespace render_map {

/// The double-precision reference of the whole map, including records that the renderer left out: of conics, or of exact rays.
tilemesh::report::Image reference_of(tilemesh::scene::Map const& map, tilemesh::splat::Camera const& camera,
                                     tilemesh::splat::Rules const& rules, tilemesh::report::Cuts cuts, unsigned threads,
                                     bool exact_rays = false);

} // namespace render_map
