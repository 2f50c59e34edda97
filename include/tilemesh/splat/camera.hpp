#pragma once
#include <cstdint>
#include <tilemesh/splat/lens.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// A camera, as every tile holds it; a pinhole unless it has a lens. Convention of OpenCV: x right, y down, z forward. Pixel (i, j) has its
/// centre at (i + 0.5, j + 0.5). A mean is visible if and only if its depth is greater than `near_depth`.
///
/// `rotation` holds the rows of the world-to-camera rotation. `position` is the camera centre c in world space, so a point p in view space
/// is R (p - c). The other form, R p + t, is wrong by up to 62 pixels at coordinates of 1e6 (tests/stability/projection.cpp, row 30).
/// Lengths are in world units; fx, fy, cx, cy, width and height are in pixels. Cost: 148 bytes a tile, 44 of them for the lens and 28 for a
/// rolling shutter, sent by the host once a frame.
struct Camera {
    float rotation[3][3];
    float position[3];
    float fx, fy, cx, cy;
    float near_depth;
    std::uint32_t width, height;
    Lens lens{};
    Shutter shutter{};
};
static_assert(sizeof(Camera) == 76 + sizeof(Lens) + sizeof(Shutter) && std::is_trivially_copyable_v<Camera>, "a camera is plain words");

/// Are both cameras equal in every bit? Then the view is static.
inline bool same_view(Camera const& a, Camera const& b) noexcept
{
    return __builtin_memcmp(&a, &b, sizeof(Camera)) == 0;
}

}}} // namespace tilemesh::splat
