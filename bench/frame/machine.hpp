#pragma once
#include <common/machine.hpp>
#include <cstdint>
#include <memory>
#include <tilemesh/renderer.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/rules.hpp>

namespace frame {

using bench::Machine;

/// The stop of every machine here, and of the rasteriser: that of 3D Gaussian Splatting, so that other programs can be compared with this
/// bench's results.
inline constexpr float stop_of_3dgs = 1e-4f;

/// The preset lossless with that stop.
enum class Kind {
    paper, ///< on Mk2, 40 x 36 tiles
    large, ///< on a test machine with storage for a twelfth of the map on each of 40 x 36 tiles
    wide   ///< on 400 x 250 tiles, of which the frame occupies 40 x 36
};

/// Do tiles whose splats and view did not change keep their pixels?
enum class Pixels { composited, kept };

std::unique_ptr<Machine> make_machine(Kind, Pixels, tilemesh::scene::Map const&, tilemesh::splat::Arithmetic, std::uint32_t threads,
                                      tilemesh::splat::Camera const&);

/// The program of homes on Mk2, with that stop.
std::unique_ptr<tilemesh::Renderer> make_homes(tilemesh::scene::Map const&, tilemesh::splat::Arithmetic, std::uint32_t threads);

} // namespace frame
