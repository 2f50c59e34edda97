#pragma once
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
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

/// The power of two at or below v > 0, between 2^-126 and 2^126; its inverse is a power of two as well.
inline float power_of_two_below(float v) noexcept
{
    constexpr std::uint32_t one_step = 1u << 23;
    std::uint32_t const exponent = __builtin_bit_cast(std::uint32_t, v) & 0x7f800000u;
    return __builtin_bit_cast(float, exponent < one_step ? one_step : exponent > 253 * one_step ? 253 * one_step : exponent);
}
inline float inverse_of_power(float power) noexcept
{
    return __builtin_bit_cast(float, (254u << 23) - __builtin_bit_cast(std::uint32_t, power));
}

/// V = J W R S and its covariance V V^T; `axis[i]` are the columns of W R in view space.
struct Factor {
    Float3 axis[3];
    float jx, jy;             ///< the Jacobian's slopes
    float px_per_x, px_per_y; ///< focal length over depth
    float a, b, c;            ///< V V^T
    float determinant;        ///< of V V^T: |v1 x v2|^2, never a c - b^2

    float longest; ///< the largest entry of V

    void multiply(float const (&scale)[3]) noexcept
    {
        float v1[3], v2[3];
        longest = 0;
        for (int i = 0; i < 3; ++i) {
            float const depth = axis[i].z;
            v1[i] = px_per_x * scale[i] * multiply_add(-jx, depth, axis[i].x);
            v2[i] = px_per_y * scale[i] * multiply_add(-jy, depth, axis[i].y);
            for (float v : {v1[i], v2[i]}) longest = std::fabs(v) > longest ? std::fabs(v) : longest;
        }
        Float3 const row1{v1[0], v1[1], v1[2]}, row2{v2[0], v2[1], v2[2]};
        a = dot(row1, row1);
        c = dot(row2, row2);
        b = dot(row1, row2);
        // |v1 x v2|^2: from the rounded rows, so that an error of a row is in a and c and here alike. Alpha depends on their
        // ratio: a determinant of its own rounding puts rho at 56 for a disc seen along its plane, this one at 1.8.
        Float3 const minor{multiply_add(v1[1], v2[2], -(v1[2] * v2[1])), multiply_add(v1[2], v2[0], -(v1[0] * v2[2])),
                           multiply_add(v1[0], v2[1], -(v1[1] * v2[0]))};
        determinant = dot(minor, minor);
    }
};

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
/// covariance is V V^T with V = J W R S (2 x 3), its determinant the squared length of the cross product of V's rows.
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
    for (float log_scale : g.log_scale)
        if (!(log_scale <= std::numeric_limits<float>::max())) return s; // -infinity is a size of zero
    float const slope_x = dot(w0, d) / z, slope_y = dot(w1, d) / z;

    // The Gaussian's axes: R from a quaternion of any length; one whose square leaves the floats' range is scaled first.
    float q[4] = {g.rotation[0], g.rotation[1], g.rotation[2], g.rotation[3]};
    float norm = multiply_add(q[0], q[0], multiply_add(q[1], q[1], multiply_add(q[2], q[2], q[3] * q[3])));
    if (!(norm > 1e-30f && norm < 1e30f)) {
        float largest = 0;
        for (float v : q) largest = std::fabs(v) > largest ? std::fabs(v) : largest;
        float const shrink = detail::inverse_of_power(detail::power_of_two_below(largest));
        for (float& v : q) v *= shrink;
        norm = multiply_add(q[0], q[0], multiply_add(q[1], q[1], multiply_add(q[2], q[2], q[3] * q[3])));
    }
    float const qw = q[0], qx = q[1], qy = q[2], qz = q[3];
    float const two = 2.0f / norm;
    float const xx = two * qx * qx, yy = two * qy * qy, zz = two * qz * qz;
    float const xy = two * qx * qy, xz = two * qx * qz, yz = two * qy * qz;
    float const wx = two * qw * qx, wy = two * qw * qy, wz = two * qw * qz;
    Float3 const axis[3] = {{1.0f - (yy + zz), xy + wz, xz - wy},
                            {xy - wz, 1.0f - (xx + zz), yz + wx},
                            {xz + wy, yz - wx, 1.0f - (xx + yy)}};
    float scale[3] = {exponential(g.log_scale[0]), exponential(g.log_scale[1]), exponential(g.log_scale[2])};

    // V and its covariance.
    float const jx = slope_x < -view.slope_limit[0] ? -view.slope_limit[0]
                     : slope_x > view.slope_limit[0] ? view.slope_limit[0]
                                                     : slope_x;
    float const jy = slope_y < -view.slope_limit[1] ? -view.slope_limit[1]
                     : slope_y > view.slope_limit[1] ? view.slope_limit[1]
                                                     : slope_y;
    detail::Factor f{{}, jx, jy, c.fx / z, c.fy / z, 0, 0, 0, 0, 0};
    for (int i = 0; i < 3; ++i) f.axis[i] = {dot(w0, axis[i]), dot(w1, axis[i]), dot(w2, axis[i])};
    f.multiply(scale);

    // Beyond 1e9 pixels the determinant would leave the floats' range: compute in units of a power of two of pixels. No axis
    // is longer than 1e18 pixels; that a real frame cannot see. An infinite length along the ray is NaN across it.
    float unit = 1.0f, per_unit = 1.0f;
    if (!(f.longest < 1e9f && f.a + f.c < 1e37f)) {
        float const steepest = std::fabs(jx) > std::fabs(jy) ? std::fabs(jx) : std::fabs(jy);
        float const most = 1e18f / ((f.px_per_x > f.px_per_y ? f.px_per_x : f.px_per_y) * (1.0f + steepest));
        for (float& v : scale) v = v < most ? v : most;
        f.multiply(scale);
        unit = detail::power_of_two_below(f.longest);
        per_unit = detail::inverse_of_power(unit);
        for (float& v : scale) v *= per_unit;
        f.multiply(scale);
    }
    float const h = m.dilation * per_unit * per_unit;
    float const a = f.a + h, cc = f.c + h, b = f.b;
    float const determinant = f.determinant + multiply_add(h, f.a + f.c, h * h);
    constexpr float huge = 1e37f; // what exceeds it was not finite
    if (!(a < huge) || !(cc < huge) || !(determinant > 0.0f) || !(determinant < huge)) return s;
    if (!(z < huge)) return s; // an infinite depth would be NaN in pixels that take no part

    // The footprint, rounded outward to whole pixels.
    float const ratio = 2.0f * std::log(g.opacity / m.alpha_min);
    float reach_x, reach_y;
    if (m.footprint == Footprint::opacity_box) {
        float const t = std::sqrt(ratio) * 1.00001f; // log and square root are rounded; the box is a superset
        reach_x = t * std::sqrt(a) * unit;
        reach_y = t * std::sqrt(cc) * unit;
    } else {
        float const half = 0.5f * (a - cc);
        float const largest = 0.5f * (a + cc) + std::sqrt(multiply_add(half, half, b * b));
        reach_x = reach_y = std::ceil(3.0f * std::sqrt(largest) * unit);
    }
    float const mean_x = c.fx * slope_x, mean_y = c.fy * slope_y;
    float const u = mean_x + c.cx, v = mean_y + c.cy;
    auto const columns = detail::pixel_span(u, reach_x, c.width);
    auto const rows = detail::pixel_span(v, reach_y, c.height);
    if (columns == 0 || rows == 0) return s;

    s.mean_px[0] = mean_x;
    s.mean_px[1] = mean_y;
    s.along = -0.5f / a * per_unit * per_unit;
    s.slope = b / a;
    s.across = -0.5f * a / determinant * per_unit * per_unit;
    s.opacity = g.opacity < 1.0f ? g.opacity : 1.0f;
    for (int i = 0; i < 3; ++i) s.colour[i] = g.colour[i];
    s.depth = z;
    // Where alpha_min is about e^-87, the exponential's end, or subnormal, every power counts.
    s.faintest = m.alpha_min > 1e-36f ? -0.5f * ratio - 0.01f : -std::numeric_limits<float>::infinity();
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
