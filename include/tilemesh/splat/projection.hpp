#pragma once
#include <cmath>
#include <cstdint>
#include <tilemesh/splat/exponential.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/view.hpp>

TILEMESH_EXACT_BEGIN
namespace tilemesh::splat {

/// A Gaussian on the screen: what compositing needs, 56 bytes. Invisible when its rectangle is empty.
///
/// The 2-D mean is relative to the principal point, in pixels: an absolute coordinate loses what the pixel centre's distance
/// needs (numerics: rho 21 against 1.5). The covariance (a b; b c), dilated, is kept as the LDL^T form of its inverse, which
/// cannot become positive by rounding: power = along dx^2 + across (dy - slope dx)^2, both factors negative.
struct Splat {
    float mean_px[2];
    float along;             ///< -1 / (2 a)
    float slope;             ///< b / a
    float across;            ///< -a / (2 (a c - b^2))
    float opacity;
    float colour[3];
    float depth;             ///< view z; greater than near
    float faintest;          ///< power below which alpha is under alpha_min, with a margin of 1 %
    std::uint32_t columns;   ///< x0 | x1 << 16: pixels outside get nothing from this splat, on whatever tile they are
    std::uint32_t rows;      ///< y0 | y1 << 16
    TileId anchor;           ///< the tile of its mean, clamped into the rectangle

    bool visible() const noexcept { return columns != 0; } // x1 is at least 1 where anything is visible
    PixelRect rect() const noexcept { return {columns & 0xffffu, columns >> 16, rows & 0xffffu, rows >> 16}; }
};
static_assert(sizeof(Splat) == 56 && std::is_trivially_copyable_v<Splat>, "a splat is 14 words");

/// No light is brighter: what exceeds it is a broken record, and would spread as infinity or NaN. Real maps reach 3.8.
inline constexpr float largest_colour = 1e6f;

namespace detail {
struct Float3 {
    float x, y, z;
};
inline float dot(Float3 a, Float3 b) noexcept
{
    return multiply_add(a.x, b.x, multiply_add(a.y, b.y, a.z * b.z));
}

/// The pixels [floor(centre - reach), floor(centre + reach)] within [0, size), as x0 | x1 << 16; 0 when there are none.
/// Compared as floats before any conversion: a radius of 3e9 must not wrap.
inline std::uint32_t pixel_span(float centre, float reach, std::uint32_t size) noexcept
{
    float const limit = static_cast<float>(size);
    float const low = std::floor(centre - reach);
    float const high = std::floor(centre + reach) + 1.0f;
    if (!(low < limit) || !(high > 0.0f)) return 0; // also when either is NaN
    auto const first = low > 0.0f ? static_cast<std::uint32_t>(low) : 0u;
    auto const last = high < limit ? static_cast<std::uint32_t>(high) : size;
    return first | last << 16;
}
/// The pixel of `centre`, clamped into a span that is not empty.
inline std::uint32_t pixel_within(float centre, std::uint32_t span) noexcept
{
    auto const first = span & 0xffffu, last = (span >> 16) - 1;
    if (!(centre > static_cast<float>(first))) return first;
    if (!(centre < static_cast<float>(last))) return last;
    return static_cast<std::uint32_t>(centre);
}
} // namespace detail

/// Projects a Gaussian: EWA splatting (Zwicker et al. 2001) as in 3DGS, in the factored form that survives needles: the
/// covariance is V V^T with V = J W R S (2 x 3), its determinant a sum of squares, never a difference.
///
/// What cannot be drawn is invisible, not an error: behind the near plane, opacity under alpha_min, nothing on screen, a
/// projection that is not finite. Cost: about 150 flops, two square roots, four divisions, four exponentials or logarithms.
inline Splat project(Gaussian const& g, View const& view, Tiling const& tiling) noexcept
{
    using detail::dot;
    using detail::Float3;
    Splat s{};
    Camera const& c = view.camera;
    Model const& m = view.model;

    // The mean in view space: subtract first, so that large coordinates cancel before they are rotated.
    Float3 const d{g.mean_world[0] - c.position[0], g.mean_world[1] - c.position[1], g.mean_world[2] - c.position[2]};
    Float3 const w0{c.rotation[0][0], c.rotation[0][1], c.rotation[0][2]};
    Float3 const w1{c.rotation[1][0], c.rotation[1][1], c.rotation[1][2]};
    Float3 const w2{c.rotation[2][0], c.rotation[2][1], c.rotation[2][2]};
    float const z = dot(w2, d);
    if (!(z > c.near_depth) || !(g.opacity >= m.alpha_min)) return s;
    for (float channel : g.colour)
        if (!(channel >= -largest_colour && channel <= largest_colour)) return s;
    float const slope_x = dot(w0, d) / z, slope_y = dot(w1, d) / z;

    // The Gaussian's axes: R from a quaternion of any length.
    float const qw = g.rotation[0], qx = g.rotation[1], qy = g.rotation[2], qz = g.rotation[3];
    float const two = 2.0f / multiply_add(qw, qw, multiply_add(qx, qx, multiply_add(qy, qy, qz * qz)));
    float const xx = two * qx * qx, yy = two * qy * qy, zz = two * qz * qz;
    float const xy = two * qx * qy, xz = two * qx * qz, yz = two * qy * qz;
    float const wx = two * qw * qx, wy = two * qw * qy, wz = two * qw * qz;
    Float3 const axis[3] = {{1.0f - (yy + zz), xy + wz, xz - wy},
                            {xy - wz, 1.0f - (xx + zz), yz + wx},
                            {xz + wy, yz - wx, 1.0f - (xx + yy)}};
    float const scale[3] = {exponential(g.log_scale[0]), exponential(g.log_scale[1]), exponential(g.log_scale[2])};

    // The rows of V, and the normal of each axis pair for the determinant.
    float const jx = slope_x < -view.slope_limit[0] ? -view.slope_limit[0]
                     : slope_x > view.slope_limit[0] ? view.slope_limit[0]
                                                     : slope_x;
    float const jy = slope_y < -view.slope_limit[1] ? -view.slope_limit[1]
                     : slope_y > view.slope_limit[1] ? view.slope_limit[1]
                                                     : slope_y;
    float const px_per_x = c.fx / z, px_per_y = c.fy / z;
    float v1[3], v2[3], normal[3];
    for (int i = 0; i < 3; ++i) {
        float const x = dot(w0, axis[i]), y = dot(w1, axis[i]), depth = dot(w2, axis[i]);
        v1[i] = px_per_x * scale[i] * multiply_add(-jx, depth, x);
        v2[i] = px_per_y * scale[i] * multiply_add(-jy, depth, y);
        normal[i] = multiply_add(x, jx, multiply_add(y, jy, depth));
    }
    Float3 const row1{v1[0], v1[1], v1[2]}, row2{v2[0], v2[1], v2[2]};
    float const a0 = dot(row1, row1), c0 = dot(row2, row2), b = dot(row1, row2);
    float const area = px_per_x * px_per_y;
    Float3 const minor{area * scale[1] * scale[2] * normal[0], area * scale[2] * scale[0] * normal[1],
                       area * scale[0] * scale[1] * normal[2]};
    float const h = m.dilation;
    float const a = a0 + h, cc = c0 + h;
    float const determinant = dot(minor, minor) + multiply_add(h, a0 + c0, h * h);
    constexpr float huge = 1e37f; // beyond it the inverse is not a normal number
    if (!(a < huge) || !(cc < huge) || !(determinant > 0.0f) || !(determinant < huge)) return s;
    if (!(z < huge)) return s; // an infinite depth would be NaN in pixels that take no part

    // The footprint, rounded outward to whole pixels.
    float const ratio = 2.0f * std::log(g.opacity / m.alpha_min);
    float reach_x, reach_y;
    if (m.footprint == Footprint::opacity_box) {
        float const t = std::sqrt(ratio) * 1.00001f; // log and square root are rounded; the box is a superset
        reach_x = t * std::sqrt(a);
        reach_y = t * std::sqrt(cc);
    } else {
        float const half = 0.5f * (a - cc);
        float const largest = 0.5f * (a + cc) + std::sqrt(multiply_add(half, half, b * b));
        reach_x = reach_y = std::ceil(3.0f * std::sqrt(largest));
    }
    float const mean_x = c.fx * slope_x, mean_y = c.fy * slope_y;
    float const u = mean_x + c.cx, v = mean_y + c.cy;
    auto const columns = detail::pixel_span(u, reach_x, c.width);
    auto const rows = detail::pixel_span(v, reach_y, c.height);
    if (columns == 0 || rows == 0) return s;

    s.mean_px[0] = mean_x;
    s.mean_px[1] = mean_y;
    s.along = -0.5f / a;
    s.slope = b / a;
    s.across = -0.5f * a / determinant;
    s.opacity = g.opacity < 1.0f ? g.opacity : 1.0f;
    for (int i = 0; i < 3; ++i) s.colour[i] = g.colour[i];
    s.depth = z;
    s.faintest = -0.5f * ratio - 0.01f;
    s.columns = columns;
    s.rows = rows;
    s.anchor = TileId::at(detail::pixel_within(u, columns) / tiling.tile_width,
                          detail::pixel_within(v, rows) / tiling.tile_height);
    return s;
}

/// What of a splat's light a pixel centre gets before anything in front of it: opacity e^power, in [0, 1]. `x` and `y` are
/// relative to the principal point. The leaf that kernels and the naive picture share.
inline float alpha_at(Splat const& s, float x, float y) noexcept
{
    float const dx = x - s.mean_px[0], dy = y - s.mean_px[1];
    float const off = multiply_add(-s.slope, dx, dy);
    float const power = multiply_add(s.along * dx, dx, s.across * off * off);
    return s.opacity * exponential(power);
}

} // namespace tilemesh::splat
TILEMESH_EXACT_END
