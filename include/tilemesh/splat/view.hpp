#pragma once
#include <cstdint>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/rules.hpp>
#include <type_traits>

TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The camera and the rules of the picture, and the bounds that follow from both: the Jacobian's limits on x/z and y/z. `make_view` makes
/// it. If the model fixes the near plane, the view's camera has that plane.
struct View {
    Camera camera;
    Rules rules;
    float slope_limit[2]; ///< jacobian_limit * tan(half field of view); a huge number if the clamp is off
};
static_assert(std::is_trivially_copyable_v<View> && sizeof(View) == 76 + 36 + 8, "a view is plain words");

inline View make_view(Camera const& camera, Rules const& rules) noexcept
{
    float const limit = rules.jacobian_limit > 0 ? rules.jacobian_limit * 0.5f : 1e30f;
    View view{camera,
              rules,
              {limit * static_cast<float>(camera.width) / camera.fx, limit * static_cast<float>(camera.height) / camera.fy}};
    if (rules.near_plane == NearPlane::fixed) view.camera.near_depth = fixed_near_depth;
    return view;
}

/// The size of a tile, in pixels.
struct TileSize {
    std::uint32_t tile_width, tile_height;
};

/// The division of a frame into tiles. Tile (x, y) owns the pixels [x w, (x + 1) w) by [y h, (y + 1) h) of the frame. A tile beyond columns
/// x rows owns no pixel.
struct Tiling : TileSize {
    std::uint32_t columns, rows; ///< tiles that hold pixels
};

inline Tiling make_tiling(std::uint32_t width, std::uint32_t height, std::uint32_t tile_width, std::uint32_t tile_height) noexcept
{
    return {{tile_width, tile_height}, (width + tile_width - 1) / tile_width, (height + tile_height - 1) / tile_height};
}

/// A half-open rectangle of pixels. It is empty if x1 <= x0 or y1 <= y0.
struct PixelRect {
    std::uint32_t x0, x1, y0, y1;
    constexpr bool empty() const noexcept { return x1 <= x0 || y1 <= y0; }
};

/// The pixels of tile t that lie in the frame.
inline PixelRect pixels_of(Tiling const& tiling, Camera const& camera, TileId t) noexcept
{
    if (t.x() >= tiling.columns || t.y() >= tiling.rows) return {0, 0, 0, 0};
    auto const x0 = t.x() * tiling.tile_width, y0 = t.y() * tiling.tile_height;
    auto const x1 = x0 + tiling.tile_width, y1 = y0 + tiling.tile_height;
    return {x0, x1 < camera.width ? x1 : camera.width, y0, y1 < camera.height ? y1 : camera.height};
}

}}} // namespace tilemesh::splat
TILEMESH_EXACT_END
