#pragma once
#include <cmath>
#include <cstdint>
#include <limits>
#include <tilemesh/splat/blending_cells.hpp>
#include <tilemesh/splat/harmonics.hpp>
#include <tilemesh/splat/projection.hpp>

/// A bound on what float32 does to a picture: beside each splat, how far its alpha may be from the exact formula's; beside each pixel, how far its
/// colour may be. report/enclosure.hpp proves more, on a host in double. This one is for tiles: it takes floats alone. With it, blending takes
/// about 1.8 times as long.
///
/// u = 2^-24. A pixel is affine in each alpha, so exchanging the computed alphas a~ for the exact a, one after the other, gives
/// |C - C~| <= M S with S = sum T~_i |a_i - a~_i|, where M is the largest difference of two colours (enclosure.hpp, 3).
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The error of a splat's alpha at a pixel centre: |a - a~| <= a~ (r0 + r2 |power|). If r0 is infinite, nothing is known but 0 <= a <= most.
struct AlphaError {
    float r0, r2;
    float at_cut;                ///< relative, where alpha is alpha_min or more
    float most;                  ///< no alpha is larger
    float colour;                ///< each channel is off by at most this
    std::uint32_t columns, rows; ///< as in `Splat`: the pixels that the exact formula may light
    std::uint32_t border_certain; ///< 0 if a pixel may be on the other side of a footprint of 3 sigma; others have no border
    bool is_wild() const noexcept { return !(r0 < std::numeric_limits<float>::infinity()); }
    /// May its depth's key be off by more than `Runs` (bounded.hpp) takes? Not of a splat that is wild because it is just outside the picture.
    bool has_wild_depth() const noexcept { return is_wild() && most >= 1; }
};

namespace detail {
inline float sum_of_magnitudes(Float3 const& a, Float3 const& b) noexcept
{
    return std::fabs(a.x * b.x) + std::fabs(a.y * b.y) + std::fabs(a.z * b.z);
}
inline float length_of(float a, float b) noexcept
{
    return std::sqrt(a * a + b * b);
}
/// Roundings of `multiply_add` (config.hpp).
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA) || defined(__IPU__)
inline constexpr float roundings_of_multiply_add = 1;
#else
inline constexpr float roundings_of_multiply_add = 2;
#endif

/// Nothing is known of the splat but that it is not brighter than opaque. It may light any pixel.
inline AlphaError wild(Camera const& c) noexcept
{
    return {std::numeric_limits<float>::infinity(), 0, 0, 1, 0, c.width << 16, c.height << 16, 1};
}
/// The largest relative error of alpha for which the constants of `alpha_error` hold.
inline constexpr float most_alpha_error = 0.1f;
} // namespace detail

/// The error of `project`'s splat: an upper bound, up to a rounding that the constants' last digits take.
///
/// 1. **V = J W R S.** View coordinates are sums of three products of rounded differences: 4.2 u of the sum of magnitudes. So are slopes, over z.
///    R of a quaternion: 8 u (1 - R_ii) + u on the diagonal and 8 u beside it (squares are rounded three times, and 2 / |q|^2 four times). With
///    the sums of W R (3 u) and those of J, an entry of V is off by dV.
/// 2. **The power.** Let M = V V^T + h, and eta = |dV| / sqrt(least eigenvalue of M). From |y^T dM y| <= 2 |dV^T y| |V^T y| + |dV^T y|^2, the power
///    changes by a factor within 1 / (1 -+ (2 eta + eta^2)): needles included. The least eigenvalue is at least det / trace and at least h.
/// 3. **a, b / a, det from the rounded V**: 4 u, 8 u sqrt(c / a) absolute, and (2 g + 9) u with g = sqrt(a0 c0 / det): a minor of the cross
///    product is the difference of two products of which one is rounded; (4 g + 9) u where both are.
/// 4. **The mean.** A shift e moves sqrt(|power|) by at most nu, the smaller one of |M^-1/2 e| by axes and |e| / sqrt(2 least eigenvalue).
/// 5. **At a pixel**: (8 + 4 q + 12) u |power| for dx, dy, off and the sum, with q = sqrt(a c / det); 4 u for e^x; 3.2 u for the products.
/// With sqrt(p) nu <= (1 + p) nu / 2, all of it is r0 + r2 p. e^x - 1 <= 1.06 x for x <= .1.
/// Anti-aliasing: sqrt(det V V^T / det M) of numbers whose errors are known.
/// 6. **`fast`** takes a pixel's row from the first row of its cell, at most 3 rows away, by three ratios (blending_cells.hpp). Let p2 be the power
///    at the pixel and A = `across`, both times log2(e). In the first row the power is at most (sqrt(p2) + 3 sqrt(A))^2 <= 2 p2 + 18 A, and its
///    terms are off by at most (36 + 6 q) u of it, as in 5 with products that are rounded; so is the rise, 2 A |off| + A <= 9.5 A + p2 / 2.
///    log2 of the opacity: 8 u |ln opacity|. The seven powers of two: 7.5e-8 of the polynomial and 12 u each; the exponent of q: 4 u 2 A; six
///    products. A splat with A > `sharpest` is evaluated pixel by pixel.
/// `fast`: is the picture that of `fast`? Then the bound is that of both.
template <class Record>
AlphaError alpha_error(Record const& g, Splat const& s, View const& view, bool fast) noexcept
{
    using namespace detail;
    constexpr float u = 0x1p-24f, twice = roundings_of_multiply_add - 1; // 1: products of a multiply_add are rounded, too
    Camera const& c = view.camera;
    Rules const& m = view.rules;
    AlphaError out{0, 0, 0, 1, 0, 0, 0, 1};
    Float3 const d{g.mean_world[0] - c.position[0], g.mean_world[1] - c.position[1], g.mean_world[2] - c.position[2]};
    Float3 const w[3] = {{c.rotation[0][0], c.rotation[0][1], c.rotation[0][2]},
                         {c.rotation[1][0], c.rotation[1][1], c.rotation[1][2]},
                         {c.rotation[2][0], c.rotation[2][1], c.rotation[2][2]}};
    float const z = dot<OneFloat>(w[2], d), z_error = 4.2f * u * sum_of_magnitudes(w[2], d);
    if (!(g.opacity >= m.alpha_min) || z + z_error <= c.near_depth) return out;
    for (float const v : g.colour)
        if (!(std::fabs(v) <= largest_colour)) return out;
    if (std::fabs(z - c.near_depth) <= z_error) return wild(c); // before or behind the near plane
    if (!(z_error <= 64 * 4.2f * u * z)) return wild(c);        // what `Runs` (bounded.hpp) requires of the key of its depth
    if (!s.visible() && !(z < 1e36f)) return wild(c);
    float const sx = dot<OneFloat>(w[0], d) / z, sy = dot<OneFloat>(w[1], d) / z;
    float const qw = g.rotation[0], qx = g.rotation[1], qy = g.rotation[2], qz = g.rotation[3];
    float const norm = squared_length<OneFloat>(qw, qx, qy, qz);
    if (!(norm > 1e-30f && norm < 1e30f)) return norm == 0 && qw == 0 && qx == 0 && qy == 0 && qz == 0 ? out : wild(c);
    float const two = 2.0f / norm;
    float const xx = two * qx * qx, yy = two * qy * qy, zz = two * qz * qz, xy = two * qx * qy, xz = two * qx * qz, yz = two * qy * qz,
                wx = two * qw * qx, wy = two * qw * qy, wz = two * qw * qz;
    Float3 const axis[3] = {{1 - (yy + zz), xy + wz, xz - wy}, {xy - wz, 1 - (xx + zz), yz + wx}, {xz + wy, yz - wx, 1 - (xx + yy)}};
    float const scale[3] = {exponential(g.log_scale[0]), exponential(g.log_scale[1]), exponential(g.log_scale[2])};
    for (float const v : g.log_scale)
        if (!(v < highest_power)) return wild(c); // below lowest_power, a size is nothing beside its error
    float const jx = limited<OneFloat>(sx, m.slope_limit[0]), jy = limited<OneFloat>(sy, m.slope_limit[1]);
    float const px = c.fx / z, py = c.fy / z;
    // 1.
    float const zr = z_error / z * 1.01f;
    float const esx = (4.2f * u * sum_of_magnitudes(w[0], d) + std::fabs(sx) * z_error) / z * 1.01f + (jx == sx ? 1 : 4) * u * std::fabs(sx),
                esy = (4.2f * u * sum_of_magnitudes(w[1], d) + std::fabs(sy) * z_error) / z * 1.01f + (jy == sy ? 1 : 4) * u * std::fabs(sy);
    float const diagonal[3] = {axis[0].x, axis[1].y, axis[2].z};
    float v1[3], v2[3], dv = 0, big = 0;
    for (int i = 0; i < 3; ++i) {
        Float3 const f{dot<OneFloat>(w[0], axis[i]), dot<OneFloat>(w[1], axis[i]), dot<OneFloat>(w[2], axis[i])};
        float const m1 = multiply_add(-jx, f.z, f.x), m2 = multiply_add(-jy, f.z, f.y);
        v1[i] = px * scale[i] * m1, v2[i] = py * scale[i] * m2;
        float const on = 8 * (1 - diagonal[i]) + 1.0f, axis_error = u * (3.1f + std::sqrt(on * on + 128.0f));
        float const e1 = axis_error * (1 + std::fabs(jx)) + esx * std::fabs(f.z) + u * (std::fabs(m1) + twice * std::fabs(jx * f.z)),
                    e2 = axis_error * (1 + std::fabs(jy)) + esy * std::fabs(f.z) + u * (std::fabs(m2) + twice * std::fabs(jy * f.z));
        float const size = scale[i] + 1.7e-38f, p1 = px * size * e1, p2 = py * size * e2;
        dv += p1 * p1 + p2 * p2, big += v1[i] * v1[i] + v2[i] * v2[i];
    }
    float const dV = std::sqrt(dv) + std::sqrt(big) * (zr + 8 * u) + 1e-30f;
    // 2.
    Float3 const r1{v1[0], v1[1], v1[2]}, r2{v2[0], v2[1], v2[2]};
    Float3 const minor = cross<OneFloat>(r1, r2);
    float const h = m.dilation, a0 = dot<OneFloat>(r1, r1), c0 = dot<OneFloat>(r2, r2), d0 = dot<OneFloat>(minor, minor);
    float const a = a0 + h, cc = c0 + h, det = d0 + multiply_add(h, a0 + c0, h * h);
    if (!(a0 + c0 < 1e18f && det > 0 && det < 1e37f)) return wild(c);
    float const least = det / (a + cc) * 0.99f > h ? det / (a + cc) * 0.99f : h;
    float const eta = dV / std::sqrt(least) * 1.02f, grow = eta * (2 + eta);
    if (!(grow < most_alpha_error)) return wild(c);
    float const theta = grow / (1 - grow), q = std::sqrt(a * cc / det) * 1.01f, g0 = std::sqrt(a0 * c0 / det);
    float const minors = 2 * (1 + twice), det_error = u * (minors * g0 + 9) + minors * u * u * g0 * g0;
    // 4.
    float opacity_error = 0, shown = g.opacity;
    if (m.coverage == Coverage::preserved) {
        // det V V^T by itself has no h that bounds it: eta with its own least eigenvalue.
        float const sharp_least = d0 / (a0 + c0) * 0.99f, sharp = sharp_least > 0 ? dV / std::sqrt(sharp_least) * 1.02f : 1.0f;
        float const kept = d0 / det, of_sharp = sharp < 0.05f ? 4.5f * sharp + u * (minors * std::sqrt(a0 * c0 / d0) + 9) : 1.0f;
        float const error = of_sharp + 4.5f * eta + det_error + 2 * u, floor = 0.000025f;
        if (kept * (1 + error) < floor * 0.99f) opacity_error = 2 * u;
        else opacity_error = 0.55f * error + 3 * u;
        if (!(opacity_error < most_alpha_error)) return wild(c);
        shown = g.opacity * std::sqrt(kept > floor ? kept : floor);
        if (shown * (1 + 1.1f * opacity_error) < m.alpha_min) return out;
    }
    float const shown_ratio = shown * (1 + opacity_error) / m.alpha_min;
    float const ratio = shown_ratio > 1 ? 2.0f * logarithm<OneFloat>(shown_ratio) : 0.0f;
    float const reach = std::sqrt(ratio + 1e-6f), edx = (c.fx * esx + u * (std::fabs(c.fx * sx) * 2 + reach * std::sqrt(a))) * 1.02f,
                edy = (c.fy * esy + u * (std::fabs(c.fy * sy) * 2 + reach * std::sqrt(cc))) * 1.02f;
    float const along = 0.5f / a, across = 0.5f * a / det, slope = std::fabs(dot<OneFloat>(r1, r2) / a);
    float const by_axes = std::sqrt(along) * edx + std::sqrt(across) * (slope * edx + edy), by_length = length_of(edx, edy) / std::sqrt(2 * least);
    float const nu = (by_axes < by_length ? by_axes : by_length) * 1.03f;
    // 5.
    float linear = theta + det_error + u * (7 + 16 * q + 20 + 4 * q), by_fast = 0;
    float const most_power = 0.5f * ratio + 0.01f, tall = std::fabs(s.across) * log2_e > 1.001f * sharpest ? 0.0f : across * log2_e;
    if (fast) {
        float const terms = (36 + 6 * q) * u;
        linear += 3.5f * terms;
        by_fast = 32.5f * terms * tall + u * (17 * tall + 8 * std::fabs(logarithm<OneFloat>(shown)) + 90) + 7 * 7.5e-8f;
    }
    float const total = linear * most_power + 2 * std::sqrt(most_power) * nu + nu * nu + opacity_error + by_fast;
    if (!(total < most_alpha_error)) return wild(c);
    out.r0 = 1.06f * (nu + nu * nu) + 7.2f * u + 1.06f * (opacity_error + by_fast);
    out.r2 = 1.06f * (linear + nu);
    float const rho = out.at_cut = 1.06f * total + 7.2f * u;
    // The exact ellipse lies in this box; with a footprint of 3 sigma, so do the pixels of both.
    float wider_x = std::sqrt(ratio + 4.4f * rho + 1e-6f) * 1.00002f * std::sqrt(a) * (1 + theta) + edx + 2e-4f,
          wider_y = std::sqrt(ratio + 4.4f * rho + 1e-6f) * 1.00002f * std::sqrt(cc) * (1 + theta) + edy + 2e-4f;
    float const column = c.fx * sx + c.cx, row = c.fy * sy + c.cy;
    wider_x += u * 2 * (std::fabs(column) + wider_x), wider_y += u * 2 * (std::fabs(row) + wider_y);
    out.columns = static_cast<std::uint32_t>(pixel_span<OneFloat>(column, wider_x, c.width));
    out.rows = static_cast<std::uint32_t>(pixel_span<OneFloat>(row, wider_y, c.height));
    if (m.footprint != Footprint::opacity_box) {
        // The radius is rounded up, and the mean down: is what they give certain?
        bool const tiles = m.footprint == Footprint::three_sigma_tiles;
        float const half = 0.5f * (a - cc), b = dot<OneFloat>(r1, r2), squared = half * half + b * b;
        float const largest = 0.5f * (a + cc) + std::sqrt(tiles && !(squared > 0.1f) ? 0.1f : squared);
        float const radius = 3.0f * std::sqrt(largest), off = 0.51f * grow + 12 * u;
        auto const span = [&](float centre, float r, std::uint32_t size) noexcept {
            float const rounded = round_up<OneFloat>(r);
            return static_cast<std::uint32_t>(tiles ? span_in_tiles<OneFloat>(static_cast<std::int32_t>(size << 16), centre, rounded, size)
                                                    : pixel_span<OneFloat>(centre, rounded, size));
        };
        auto const within = [&](float centre, float error, std::uint32_t size, std::uint32_t& may) noexcept {
            error += 4 * u * (std::fabs(centre) + radius);
            std::uint32_t const first = span(centre - error, radius * (1 - off), size), last = span(centre + error, radius * (1 - off), size),
                                wide_first = span(centre - error, radius * (1 + off), size),
                                wide_last = span(centre + error, radius * (1 + off), size);
            if (first != last || first != wide_first || first != wide_last) out.border_certain = 0;
            std::uint32_t from = wide_first & 0xffffu, to = wide_last >> 16;
            from = from > (may & 0xffffu) ? from : may & 0xffffu, to = to < may >> 16 ? to : may >> 16;
            may = from < to ? from | to << 16 : 0;
        };
        within(column, edx, c.width, out.columns), within(row, edy, c.height, out.rows);
    }
    if (out.columns == 0 || out.rows == 0) out.columns = out.rows = 0;
    if (!s.visible()) out.r0 = std::numeric_limits<float>::infinity(), out.most = 1.5f * m.alpha_min; // only just outside the picture
    if constexpr (Record::sh_degree > 0) {
        // The direction is off by 6 u in each component, and a function of degree 3 has a slope of at most 5; the functions, and the sums.
        for (std::uint32_t k = 0; k < 3; ++k) {
            float of_channel = 20 * std::fabs(g.colour[k]), most = std::fabs(g.colour[k]);
            for (std::uint32_t i = 0; i < harmonics_per_channel(Record::sh_degree); ++i)
                of_channel += 128 * std::fabs(g.harmonics[3 * i + k]), most += 1.5f * std::fabs(g.harmonics[3 * i + k]);
            out.colour = u * of_channel > out.colour ? u * of_channel : out.colour;
            if (!(most <= largest_colour)) out.colour = std::numeric_limits<float>::infinity(); // `shade` may leave it out
        }
    }
    return out;
}

/// What a row of a block has: the picture, and what its bound is made of: the transmittance and its error, the sum S; of a run, its terms and
/// where it began; the greatest and the least colour that a pixel may see, and the largest error of one.
struct alignas(detail::vector_bytes) BoundRow {
    float t[block_width], red[block_width], green[block_width], blue[block_width];
    float e[block_width], s[block_width], high[block_width], low[block_width], colour[block_width], sum[block_width], start[block_width];
    /// Pixels outside the columns [x0, x1) are dead, as in `CellFields`.
    void begin(Rules const& m, std::uint32_t x0, std::uint32_t x1) noexcept
    {
        *this = {};
        float most = 0, least = 0;
        for (float const b : m.background) most = b > most ? b : most, least = b < least ? b : least;
        for (std::uint32_t i = 0; i < block_width; ++i) t[i] = start[i] = i >= x0 && i < x1 ? 1.0f : -1.0f, high[i] = most, low[i] = least;
    }
    /// No float and no real number goes on.
    bool is_done(float limit) const noexcept
    {
        float most = 0;
        for (std::uint32_t i = 0; i < block_width; ++i) most = t[i] + e[i] > most ? t[i] + e[i] : most;
        return most < limit;
    }
    /// Each channel is within this of the exact formula. A sum of n floats that are not negative is off by n u of itself: 2^15 of them take .004.
    float bound(std::uint32_t i) const noexcept
    {
        float const sum_of = s[i] * 1.005f;
        return (high[i] - low[i]) * (sum_of + 0x1p-23f) + colour[i] * (1.01f + sum_of);
    }
    Blended blended(std::uint32_t i, float const (&background)[3]) const noexcept
    {
        float const through = std::fabs(t[i]);
        if (is_black(background)) return {{red[i], green[i], blue[i]}, through, 0, 0};
        return {{multiply_add(through, background[0], red[i]), multiply_add(through, background[1], green[i]),
                 multiply_add(through, background[2], blue[i])}, through, 0, 0};
    }
};

/// How a splat stands in the order: alone, the first of a run of splats whose exact order may be another, or a later one of it.
struct InRun {
    bool first, later;
};

namespace detail {
template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> power_at(Splat const& p, Floats<N> const& dx, float dy) noexcept
{
    Floats<N> const off = multiply_add_lanes<N>(broadcast<N>(-p.slope), dx, broadcast<N>(dy));
    return multiply_add_lanes<N>(p.along * dx, dx, p.across * off * off);
}
/// A splat beside N pixels of a row: its alpha (below 0 beside its own columns), and alpha's relative error.
template <std::uint32_t N>
struct BoundedAlpha {
    Floats<N> alpha, clamped, error;
    TILEMESH_KERNEL BoundedAlpha(AlphaError const& e, Floats<N> const& power, Floats<N> const& opacity, Rules const& m, float lowest) noexcept
    {
        alpha = opacity * exponential_lanes<N>(power, lowest);
        clamped = alpha < m.alpha_max ? alpha : broadcast<N>(m.alpha_max);
        error = multiply_add_lanes<N>(broadcast<N>(-e.r2), at_least<N>(power, broadcast<N>(lowest)), broadcast<N>(e.is_wild() ? 0.0f : e.r0));
    }
};
/// What changes of N pixels of a row where nothing is in doubt.
template <std::uint32_t N>
struct BoundPixels {
    Floats<N> t, red, green, blue, e, s, high, colour;
    TILEMESH_KERNEL BoundPixels(BoundRow const& b, std::uint32_t i) noexcept
        : t(load<N>(b.t + i)), red(load<N>(b.red + i)), green(load<N>(b.green + i)), blue(load<N>(b.blue + i)), e(load<N>(b.e + i)),
          s(load<N>(b.s + i)), high(load<N>(b.high + i)), colour(load<N>(b.colour + i))
    {
    }
    TILEMESH_KERNEL void store_in(BoundRow& b, std::uint32_t i) const noexcept
    {
        put<N>(b.t + i, t), put<N>(b.red + i, red), put<N>(b.green + i, green), put<N>(b.blue + i, blue);
        put<N>(b.e + i, e), put<N>(b.s + i, s), put<N>(b.high + i, high), put<N>(b.colour + i, colour);
    }
};
/// Adds a splat to N pixels of a row where no float decides otherwise than the exact formula: the splat's rectangle and place in the order are
/// certain, and no pixel is near the cut (within `near_cut`) or near the stop. Otherwise it returns false, and has changed nothing. The bits are
/// those of `bound_pixels`. `seen` counts the pairs that contributed.
template <std::uint32_t N, bool Drops>
TILEMESH_KERNEL bool bound_certain_pixels(BoundPixels<N>& b, Splat const& p, AlphaError const& e, BoundedAlpha<N> const& of, float most_colour,
                                          float near_cut, Rules const& m, Words<N>& seen) noexcept
{
    using F = Floats<N>;
    constexpr float u = 0x1p-24f;
    F const zero{};
    float const cut = m.alpha_min, limit = m.transmittance_min;
    Words<N> const alive = b.t >= limit, has = of.alpha >= cut, may_go_on = b.t + b.e >= limit;
    Words<N> in = has & alive;
    F const share = of.clamped * b.t, would_be = b.t - share;
    [[maybe_unused]] Words<N> const in0 = in;
    if constexpr (Drops) in &= would_be >= limit;
    F const w = in ? share : zero, a_in = in ? of.clamped : zero;
    F const step = multiply_add_lanes<N>(w, of.error, in ? broadcast<N>(2 * u) : zero);
    F const err = multiply_add_lanes<N>(b.e * a_in, of.error - 1.0f, b.e) + step;
    F after = b.t - w;
    F const away = magnitude<N>((Drops ? would_be : after) - limit);
    Words<N> const doubtful = may_go_on & (magnitude<N>(of.alpha - cut) <= near_cut); // where a float has stopped, the exact formula may see it
    Words<N> near_stop;
    if constexpr (Drops) near_stop = in0 & (away <= err * 1.01f + b.t * of.clamped * of.error + 2 * u);
    else near_stop = in & (away <= err * 1.01f);
    if (any_pixel<N>(doubtful | near_stop) != 0) return false;
    if constexpr (Drops) after = (in0 & ~in) ? -b.t : after;
    Words<N> const may_see = has & may_go_on;
    b.high = (may_see & (b.high < most_colour)) ? broadcast<N>(most_colour) : b.high;
    if (e.colour > 0) b.colour = (may_see & (b.colour < e.colour)) ? broadcast<N>(e.colour) : b.colour;
    b.red = multiply_add_lanes<N>(w, broadcast<N>(p.colour[0]), b.red);
    b.green = multiply_add_lanes<N>(w, broadcast<N>(p.colour[1]), b.green);
    b.blue = multiply_add_lanes<N>(w, broadcast<N>(p.colour[2]), b.blue);
    b.t = after, b.e = err, b.s = b.s + step;
    seen = in ? seen + 1 : seen;
    return true;
}
/// Adds a splat to N pixels of a row, from column `i` of the row on. `p` and `e`: the splat and its error.
///
/// A term of which a float may decide otherwise whether it is there costs T a. Where T is within its error of the limit, the stop may come here
/// or later, and costs T; with `Stop::before_crossing` it costs what the term saw. Terms of a run cost T a_i a_j a pair: that is what it
/// changes at most if j is in front of i.
template <std::uint32_t N, bool Drops>
TILEMESH_KERNEL void bound_pixels(BoundRow& b, std::uint32_t i, Splat const& p, AlphaError const& e, Floats<N> const& dx, float dy,
                                  Rules const& m, std::uint32_t column, std::uint32_t row, InRun run, Words<N>& seen) noexcept
{
    using F = Floats<N>;
    constexpr float u = 0x1p-24f;
    F const zero = broadcast<N>(0.0f), one = broadcast<N>(1.0f), at = __builtin_convertvector(counted_lanes<N>(), F) + static_cast<float>(i);
    float const cut = m.alpha_min, limit = m.transmittance_min;
    auto const own = p.rect();
    bool const own_row = p.visible() && row >= own.y0 && row < own.y1, wild = e.is_wild();
    bool const may_row = row >= (e.rows & 0xffffu) && row < e.rows >> 16;
    auto const from_column = [&](std::uint32_t x) noexcept {
        return static_cast<float>(static_cast<std::int32_t>(x) - static_cast<std::int32_t>(column));
    };
    float const own_from = own_row ? from_column(own.x0) : 1e9f, own_to = from_column(own.x1);
    float const may_from = may_row ? from_column(e.columns & 0xffffu) : 1e9f, may_to = from_column(e.columns >> 16);
    float const most_wild = wild ? e.most : 0.0f;
    // Relative to the cut: alpha is surely there, or perhaps.
    float const surely = wild || e.border_certain == 0 ? 0.0f : 1 - 1.05f * e.at_cut, perhaps = 1 + 1.05f * e.at_cut;
    float most_colour = p.visible() ? p.colour[0] : largest_colour, least_colour = p.visible() ? p.colour[0] : 0.0f;
    for (float const v : p.colour) most_colour = v > most_colour ? v : most_colour, least_colour = v < least_colour ? v : least_colour;
    BoundedAlpha<N> const of(e, power_at<N>(p, dx, dy), broadcast<N>(p.opacity), m, lowest_power_for(m.alpha_min));
    F const a0 = of.alpha, a = of.clamped, r = of.error;
    F const before = load<N>(b.t + i), error = load<N>(b.e + i);
    F const alive = before >= limit ? one : zero;
    F const inside = (at >= own_from ? one : zero) * (at < own_to ? one : zero), may = (at >= may_from ? one : zero) * (at < may_to ? one : zero);
    F const in0 = (a0 >= cut ? one : zero) * inside * alive, share = a * before, would_be = before - share;
    F const in = Drops ? (would_be < limit ? zero : in0) : in0;
    F const w = in > zero ? share : zero, a_in = in > zero ? a : zero;
    F const after = Drops ? (in0 > in ? -before : before - w) : before - w;
    F const certain = (a0 * surely > cut ? one : zero) * inside;
    F const possible = wild ? one : (a0 * perhaps >= cut ? one : zero);
    F const doubt = alive * may * possible * (one - certain), size = wild ? broadcast<N>(most_wild) : 1.05f * a0;
    F const step = multiply_add_lanes<N>(w, r, 2 * u * in) + (doubt > zero ? doubt * size * before : zero);
    F err = multiply_add_lanes<N>(error * a_in, r - one, error) + step;
    F const seen_of = Drops ? would_be : before - w, over = seen_of - limit, away = over > zero ? over : zero - over;
    F const there = in0 > doubt ? in0 : doubt;
    F const close = away <= (Drops ? err * 1.01f + before * a * r + 2 * u : err * 1.01f) ? one : zero;
    F const falls = doubt * (before - size * before < limit ? one : zero);
    F const stops = there * (close > falls ? close : falls);
    F s = load<N>(b.s + i) + step + (stops > zero ? (Drops ? before : limit * 1.02f + err) : zero);
    // Where a float has stopped and the exact formula may not have, later splats are still seen.
    if (Drops) err = err + (stops * (in0 - in) > zero ? 2.0f * before : zero);
    if (run.first || run.later) {
        F const start = run.first ? before + error : load<N>(b.start + i), part = may * possible * size;
        F const sum = run.first ? zero : load<N>(b.sum + i), going = start >= limit ? one : zero;
        s = s + start * part * sum * going;
        // The stop may be at another one of the run.
        s = s + (part > zero ? going : zero) * (after < limit * 1.02f ? one : zero) * (run.later ? limit * 1.02f : 0.0f);
        put<N>(b.start + i, start), put<N>(b.sum + i, sum + part);
    }
    auto const may_see = may * possible * (before + error >= limit ? one : zero) > zero;
    F const high = load<N>(b.high + i), low = load<N>(b.low + i), colour = load<N>(b.colour + i);
    put<N>(b.high + i, (may_see & (high < most_colour)) ? broadcast<N>(most_colour) : high);
    put<N>(b.low + i, (may_see & (low > least_colour)) ? broadcast<N>(least_colour) : low);
    put<N>(b.colour + i, (may_see & (colour < e.colour)) ? broadcast<N>(e.colour) : colour);
    put<N>(b.red + i, multiply_add_lanes<N>(w, broadcast<N>(p.colour[0]), load<N>(b.red + i)));
    put<N>(b.green + i, multiply_add_lanes<N>(w, broadcast<N>(p.colour[1]), load<N>(b.green + i)));
    put<N>(b.blue + i, multiply_add_lanes<N>(w, broadcast<N>(p.colour[2]), load<N>(b.blue + i)));
    put<N>(b.t + i, after), put<N>(b.e + i, err), put<N>(b.s + i, s);
    seen -= in > zero;
}
} // namespace detail

}}} // namespace tilemesh::v0_2::splat
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
