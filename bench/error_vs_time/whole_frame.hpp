#pragma once
#include "knobs.hpp"
#include <cstdint>
#include <span>
#include <tilemesh/report/image.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/model.hpp>
#include <tilemesh/splat/view.hpp>

namespace error_vs_time {

/// The whole frame in float32, without a mesh: one sort of all splats, and each visits its pixels. With `precise` arithmetic a naive
/// loop that shares with the kernels only how a record is projected and `alpha_at`; with `fast`, whose alpha depends on the frame's
/// blocks, the blending kernel over the frame as one tile.
tilemesh::report::Image whole_frame(std::span<splat::Gaussian const> gaussians, splat::Camera const& camera, splat::Model const& model,
                                    Knobs const& knobs);

} // namespace error_vs_time
