#pragma once
#include <tilemesh/config.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// A map that needs no file. It shows a desk with a monitor that says TILEMESH, a keyboard, a mug, books, a ball, pencils and a plant, in
/// front of thirteen blobs several metres wide. It has about 40,000 Gaussians, of every kind that occurs in SLAM maps: discs on surfaces,
/// needles (anisotropy above 100), balls and blobs. 3 % of them are exactly opaque. Units are metres, y points down, and the desk top is y
/// = 0.
///
/// Every run gives the same map. Its random numbers come from integer arithmetic. Positions and colours are computed with `sin`, `log` and
/// `sqrt` in double precision and rounded to float once. So a last bit may differ between C libraries, and between builds with and without
/// fused operations.
///
/// Cost: 2.4 MB and about 20 ms.
TILEMESH_HOST Map built_in_map();

/// The camera for which the built-in map is composed: in front of the desk, at the eyes of a person who sits there; 60 degrees wide. Throws
/// `Error` for a side outside 1..65535.
TILEMESH_HOST splat::Camera built_in_camera(Size size);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/built_in_code.hpp>
#endif
