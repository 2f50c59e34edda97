#pragma once
#include <cmath>
#include <cstdint>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/rules.hpp>
#include <type_traits>

TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The camera and the rules of the picture. `make_view` makes it. If the rules fix the near plane, the view's camera has that plane. The rules
/// have the bounds of the slopes; they are huge if there are none.
struct View {
    Camera camera;
    Rules rules;
};
static_assert(std::is_trivially_copyable_v<View> && sizeof(View) == sizeof(Camera) + 44, "a view is plain words");

namespace detail {
/// Twice the distance, in pixels, from the principal point to the border that bounds a slope.
inline float twice_to_border(float centre, std::uint32_t size, SlopeBorder border) noexcept
{
    float const all = static_cast<float>(size), after = all - centre;
    return border == SlopeBorder::of_half_width ? all : 2.0f * (centre > after ? centre : after);
}
} // namespace detail

/// Sets `limit` and `ends` of a lens (Lens), and `reach` of a shutter, from the picture's size, unless they are given. Cost: about 10,000 flops,
/// for a lens that bends.
inline void bound_lens(Camera& c) noexcept
{
    Lens& lens = c.lens;
    if (c.shutter.reach == 0 && c.shutter.rolls()) {
        float const above = c.cy / c.fy, below = (static_cast<float>(c.height) - c.cy) / c.fy;
        c.shutter.reach = above > below ? above : below;
    }
    if (lens.kind == LensKind::fov) lens.k[1] = detail::twice_tangent(lens.k[0]);
    if (lens.kind == LensKind::pinhole || lens.kind == LensKind::equirectangular || lens.limit != 0) return;
    float const u[2] = {-c.cx / c.fx, (static_cast<float>(c.width) - c.cx) / c.fx};
    float const v[2] = {-c.cy / c.fy, (static_cast<float>(c.height) - c.cy) / c.fy};
    float farthest = 0;
    for (float const x : u)
        for (float const y : v) farthest = x * x + y * y > farthest ? x * x + y * y : farthest;
    farthest = std::sqrt(farthest);
    if (lens.kind == LensKind::fov) { // in closed form, with no function of a library: the limit has equal bits everywhere
        float const angle = lens.k[0] * farthest, widest = angle < 1.55f ? 0.5f * detail::twice_tangent(2 * angle) / lens.k[1] : 64;
        lens.limit = widest < 64 ? widest : 64;
        lens.ends = widest < 64 ? 0 : 1;
        return;
    }
    LensReach<float> const reach = reach_of<float>(lens, farthest);
    float widest = reach.radius;
    if (lens.kind == LensKind::opencv && widest < reach.fold && (lens.p[0] != 0 || lens.p[1] != 0))
        for (float const to_x : u)
            for (float const to_y : v) {
                float x = to_x * reach.radius / farthest, y = to_y * reach.radius / farthest, at[2], by[3];
                for (int i = 0; i < 8; ++i) { // Newton's method, from the place without the tangential part
                    bend_slopes<float>(lens, x, y, at, by);
                    float const e = to_x - at[0], f = to_y - at[1], determinant = by[0] * by[2] - by[1] * by[1];
                    if (!(determinant > 0)) break;
                    x += (by[2] * e - by[1] * f) / determinant, y += (by[0] * f - by[1] * e) / determinant;
                }
                float const r = std::sqrt(x * x + y * y);
                if (r > widest && r < reach.fold) widest = r;
            }
    bool const found = reach.radius < reach.fold, folds = reach.is_fold && !(found && reach.fold > 1.3f * widest);
    bool const angle = lens.kind == LensKind::fisheye;
    lens.limit = folds ? 0.95f * reach.fold : angle ? reach.fold : widest;
    lens.ends = angle || folds || !found ? 1 : 0;
}

inline View make_view(Camera const& camera, Rules const& rules) noexcept
{
    float const limit = rules.jacobian_limit > 0 ? rules.jacobian_limit * 0.5f : 1e30f;
    View view{camera, rules};
    float(&bound)[2] = view.rules.slope_limit;
    if (!(bound[0] > 0)) bound[0] = limit * detail::twice_to_border(camera.cx, camera.width, rules.slope_border) / camera.fx;
    if (!(bound[1] > 0)) bound[1] = limit * detail::twice_to_border(camera.cy, camera.height, rules.slope_border) / camera.fy;
    if (rules.near_plane == NearPlane::fixed) view.camera.near_depth = fixed_near_depth;
    bound_lens(view.camera);
    return view;
}

/// The rules with which any window of this camera's picture is rendered as in the whole picture: with the picture's bounds of the slopes.
inline Rules bounds_of(Camera const& picture, Rules const& rules) noexcept
{
    return make_view(picture, rules).rules;
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
    auto const parts = [](std::uint32_t size, std::uint32_t part) { return size / part + (size % part != 0 ? 1u : 0u); }; // no sum that wraps
    return {{tile_width, tile_height}, parts(width, tile_width), parts(height, tile_height)};
}

/// A half-open rectangle of pixels. It is empty if x1 <= x0 or y1 <= y0.
struct PixelRect {
    std::uint32_t x0, x1, y0, y1;
    constexpr bool empty() const noexcept { return x1 <= x0 || y1 <= y0; }
};

/// The camera that sees a window of this camera's picture. With `precise` arithmetic, the rules `bounds_of(picture, rules)` and a principal
/// point that floats subtract exactly (a multiple of 1/128 pixel), every pixel of the window has the bits of the picture's.
inline Camera window_of(Camera picture, PixelRect const& window) noexcept
{
    bound_lens(picture);
    picture.cx -= static_cast<float>(window.x0);
    picture.cy -= static_cast<float>(window.y0);
    picture.width = window.x1 - window.x0;
    picture.height = window.y1 - window.y0;
    return picture;
}

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
