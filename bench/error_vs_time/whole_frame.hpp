#pragma once
#include "knobs.hpp"
#include <cstdint>
#include <span>
#include <tilemesh/report/image.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/rules.hpp>
#include <tilemesh/splat/view.hpp>

namespace error_vs_time {

/// Renders the whole frame in float32, without a mesh: one sort of all splats, and each splat visits its pixels. With `precise` arithmetic
/// it is a naive loop; it shares with the kernels only the projection of a record and `alpha_at`. With `fast`, alpha depends on the frame's
/// blocks, so it is the blending kernel with the frame as one tile.
tilemesh::report::Image whole_frame(std::span<splat::Gaussian const> gaussians, splat::Camera const& camera, splat::Rules const& rules,
                                    Knobs const& knobs);

} // namespace error_vs_time
