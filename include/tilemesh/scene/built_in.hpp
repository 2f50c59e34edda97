#pragma once
#include <tilemesh/config.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// The map that needs no file: a desk with a monitor that says TILEMESH, a keyboard, a mug, books,
/// a ball, pencils and a plant, before thirteen blobs several metres wide. About 40,000 Gaussians,
/// of every kind a SLAM map has: discs on surfaces, needles (anisotropy above 100), balls, blobs;
/// three in a hundred are exactly opaque. Metres, y down; the desk top is y = 0.
///
/// The same on every run. Its random numbers are integer arithmetic; positions and colours go
/// through `sin`, `log` and `sqrt` in double precision and are rounded to float once, so a last bit
/// may differ between C libraries, and between builds with and without fused operations.
///
/// Cost: 2.4 MB and some 20 ms.
TILEMESH_HOST Map built_in_map();

/// The camera that the built-in map is composed for: before the desk, at the eyes of somebody who
/// sits there; 60 degrees wide. Throws `Error` for a side outside 1..65535.
TILEMESH_HOST splat::Camera built_in_camera(Size size);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/built_in_code.hpp>
#endif
