#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// A pinhole camera as every tile holds it. OpenCV convention: x right, y down, z forward; pixel (i, j) has its centre at
/// (i + 0.5, j + 0.5); a mean is visible iff its depth is greater than `near_depth`.
///
/// `rotation` holds the rows of the world-to-camera rotation; `position` is the camera centre in world space, so that a view
/// point is R (p - c): R p + t loses up to 62 pixels at coordinates of 1e6 (numerics, row 30). Lengths in world units; fx,
/// fy, cx, cy, width and height in pixels. Cost: 76 bytes a tile, sent by the host once a frame.
struct Camera {
    float rotation[3][3];
    float position[3];
    float fx, fy, cx, cy;
    float near_depth;
    std::uint32_t width, height;
};
static_assert(sizeof(Camera) == 76 && std::is_trivially_copyable_v<Camera>, "a camera is plain words");

/// Equal in every bit: the view is static.
inline bool same_view(Camera const& a, Camera const& b) noexcept
{
    return __builtin_memcmp(&a, &b, sizeof(Camera)) == 0;
}

}}} // namespace tilemesh::splat
