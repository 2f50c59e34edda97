#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>
#include <type_traits>

namespace tilemesh::splat {

/// A Gaussian's identity, unique in a map. 0 marks a free slot and is never an id (the paper, section "Routing protocol").
enum class GaussianId : std::uint32_t { none = 0 };

/// One primitive of a map: the record a tile stores and a channel carries (the paper's table in section "Gaussian
/// Representation"): 60 bytes of plain words.
///
/// Spaces and units: `mean_world` in world units; `colour` is linear RGB, `0.28209479 f_dc + 0.5` clamped at 0 from below
/// (real maps reach 3.8: never clamp above); `opacity` in [0, 1], after the sigmoid; `rotation` is a quaternion w, x, y, z
/// of any length but zero; `log_scale` is the natural logarithm of the standard deviation along each local axis.
struct Gaussian {
    float mean_world[3];
    float colour[3];
    float opacity;
    float rotation[4];
    float log_scale[3];
    GaussianId id;
};
static_assert(sizeof(Gaussian) == 60 && alignof(Gaussian) == 4 && std::is_trivially_copyable_v<Gaussian>,
              "the record of the paper is 60 bytes");

} // namespace tilemesh::splat
