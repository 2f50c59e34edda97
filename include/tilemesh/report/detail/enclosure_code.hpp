#pragma once
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/joined_threads.hpp>
#include <tilemesh/report/detail/ball.hpp>
#include <tilemesh/report/enclosure.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/rules.hpp>
#include <utility>
#include <vector>

TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace report::detail {

#if TILEMESH_HAS_QUAD
// --- 1. projection ------------------------------------------------------------------------------------------------------
/// A splat of the exact formula: mean in pixels, power = along dx^2 + across (dy - slope dx)^2, and the covariance's xx and yy.
struct BallSplat {
    Ball x, y, along, slope, across, xx, yy, opacity, colour[3];
};
/// Pixels, half-open.
struct PixelBox {
    std::int32_t x0, x1, y0, y1;
    bool empty() const { return x1 <= x0 || y1 <= y0; }
    bool contains(std::int32_t x, std::int32_t y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
};
/// The same in double. At each pixel that the exact formula may light, |alpha - computed alpha| <= rho * computed alpha.
struct DoubleSplat {
    double x, y, along, slope, across, opacity, rho;
    double colour[3], colour_error;
    PixelBox may, must; ///< pixels outside `may` get nothing; pixels inside `must` are in the rules' footprint
    std::uint32_t record;
};

inline Ball dot(Ball const* a, Ball const* b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The view depth of a record less `less`: the sign of an exact sum. Requires finite numbers.
inline int depth_sign(splat::Camera const& c, splat::Gaussian const& g, float less)
{
    ExactSum s;
    for (int k = 0; k < 3; ++k) s.add_product(c.rotation[2][k], g.mean_world[k], 1), s.add_product(c.rotation[2][k], c.position[k], -1);
    s.add(-double{less});
    return s.sign();
}
/// The sign of depth(a) - depth(b): the camera's position cancels.
inline int compare_depth(splat::Camera const& c, splat::Gaussian const& a, splat::Gaussian const& b)
{
    ExactSum s;
    for (int k = 0; k < 3; ++k) s.add_product(c.rotation[2][k], a.mean_world[k], 1), s.add_product(c.rotation[2][k], b.mean_world[k], -1);
    return s.sign();
}

/// pi to 113 bits: the double nearest to it and the rest, whose own error is below 2^-108.
inline Ball pi_ball()
{
    return {Quad(3.141592653589793116) + Quad(1.2246467991473532e-16), 1e-31};
}

/// The colour that the camera sees: the sum of real spherical harmonics with the Condon-Shortley sign, each K P_l^m(z) times the real or
/// imaginary part of (x + i y)^m, where P_l^m is without its factor (1 - z^2)^(m / 2): by recurrence from P_m^m = (2m - 1)!!.
inline void set_colour(BallSplat& out, EnclosedRecord const& record, Ball const (&to_mean)[3])
{
    for (int c = 0; c < 3; ++c) out.colour[c] = record.gaussian->colour[c];
    if (record.degree == 0) return;
    Ball const length = root(dot(to_mean, to_mean));
    Ball d[3];
    for (int i = 0; i < 3; ++i) d[i] = to_mean[i] / length;
    Ball const quarter = Ball(0.25) / pi_ball();
    int k = 0;
    for (int l = 1; l <= static_cast<int>(record.degree); ++l)
        for (int m = -l; m <= l; ++m, ++k) {
            int const order = m < 0 ? -m : m;
            Ball real = 1, imaginary = 0, legendre = 1, previous = 0, ratio = 1; // ratio: (l - |m|)! / (l + |m|)!
            for (int i = 0; i < order; ++i) {
                Ball const next = real * d[0] - imaginary * d[1];
                imaginary = real * d[1] + imaginary * d[0], real = next;
                legendre = legendre * Ball(2 * i + 1);
            }
            for (int i = order + 1; i <= l; ++i) {
                Ball const next = (Ball(2 * i - 1) * d[2] * legendre - Ball(i + order - 1) * previous) / Ball(i - order);
                previous = legendre, legendre = next;
            }
            for (int i = l - order + 1; i <= l + order; ++i) ratio = ratio / Ball(i);
            Ball basis = root(Ball((order == 0 ? 1 : 2) * (2 * l + 1)) * quarter * ratio) * legendre * (m < 0 ? imaginary : real);
            if (order % 2 != 0) basis = -basis;
            for (int c = 0; c < 3; ++c) out.colour[c] = out.colour[c] + basis * Ball(record.harmonics[3 * k + c]);
        }
    for (Ball& c : out.colour) c = larger(Ball(0), c);
}

/// Nothing for a record that no ball encloses.
inline std::optional<BallSplat> project_in_balls(EnclosedRecord const& record, splat::Camera const& c, splat::Rules const& rules)
{
    auto const& g = *record.gaussian;
    Ball w[3][3], d[3], view[3];
    for (int i = 0; i < 3; ++i) d[i] = Ball(g.mean_world[i]) - Ball(c.position[i]);
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) w[i][k] = c.rotation[i][k];
        view[i] = dot(w[i], d);
    }
    Ball const z = view[2], sx = view[0] / z, sy = view[1] / z;
    Ball jx = sx, jy = sy;
    if (rules.jacobian_limit > 0) {
        auto const limit = [&](float given, float centre, std::uint32_t size, float focal) -> Ball {
            if (given > 0) return given;
            Ball const all = static_cast<double>(size);
            Ball const half = rules.slope_border == splat::SlopeBorder::of_half_width ? all * Ball(0.5) : larger(centre, all - Ball(centre));
            return Ball(rules.jacobian_limit) * half / Ball(focal);
        };
        Ball const lx = limit(rules.slope_limit[0], c.cx, c.width, c.fx), ly = limit(rules.slope_limit[1], c.cy, c.height, c.fy);
        jx = larger(-lx, smaller(lx, sx)), jy = larger(-ly, smaller(ly, sy));
    }
    Ball q[4], norm = 0;
    for (int i = 0; i < 4; ++i) q[i] = g.rotation[i], norm = norm + q[i] * q[i];
    Ball const s = Ball(2) / norm;
    Ball const &qw = q[0], &qx = q[1], &qy = q[2], &qz = q[3];
    Ball const axis[3][3] = {{Ball(1) - s * (qy * qy + qz * qz), s * (qx * qy + qw * qz), s * (qx * qz - qw * qy)},
                             {s * (qx * qy - qw * qz), Ball(1) - s * (qx * qx + qz * qz), s * (qy * qz + qw * qx)},
                             {s * (qx * qz + qw * qy), s * (qy * qz - qw * qx), Ball(1) - s * (qx * qx + qy * qy)}};
    // V = J W R S, row by row; the covariance is V V^T + dilation, and its determinant |v1 x v2|^2 + h (|v1|^2 + |v2|^2) + h^2 cancels nothing.
    Ball const px = Ball(c.fx) / z, py = Ball(c.fy) / z;
    Ball v1[3], v2[3];
    for (int i = 0; i < 3; ++i) {
        Ball const scale = exponential(g.log_scale[i]);
        Ball const ax = dot(w[0], axis[i]), ay = dot(w[1], axis[i]), az = dot(w[2], axis[i]);
        v1[i] = px * scale * (ax - jx * az), v2[i] = py * scale * (ay - jy * az);
    }
    Ball const n[3] = {v1[1] * v2[2] - v1[2] * v2[1], v1[2] * v2[0] - v1[0] * v2[2], v1[0] * v2[1] - v1[1] * v2[0]};
    Ball const sharp_xx = dot(v1, v1), sharp_yy = dot(v2, v2), sharp = dot(n, n), h = rules.dilation;
    BallSplat out;
    out.xx = sharp_xx + h, out.yy = sharp_yy + h;
    Ball const determinant = sharp + h * (sharp_xx + sharp_yy) + h * h;
    out.x = Ball(c.fx) * sx + Ball(c.cx), out.y = Ball(c.fy) * sy + Ball(c.cy);
    out.along = Ball(-0.5) / out.xx, out.slope = dot(v1, v2) / out.xx, out.across = Ball(-0.5) * out.xx / determinant;
    out.opacity = std::min(g.opacity, 1.0f);
    if (rules.coverage == splat::Coverage::preserved) {
        Ball const least(Quad(25) / Quad(1000000), 1e-37);
        out.opacity = out.opacity * root(larger(least, sharp / determinant));
    }
    set_colour(out, record, d);
    bool finite = lower(determinant) > 0 && lower(out.xx) > 0 && lower(out.yy) > 0 && is_finite(determinant);
    for (Ball const* b :
         {&out.x, &out.y, &out.along, &out.slope, &out.across, &out.xx, &out.yy, &out.opacity, &out.colour[0], &out.colour[1], &out.colour[2]})
        finite = finite && is_finite(*b);
    return finite ? std::optional(out) : std::nullopt;
}

/// e^x for -700 <= x <= 0. The relative error is below 2^-49, with or without a fused operation. u = 2^-53; |r| <= .3466. Reduction: n has
/// 10 bits and the first part of ln 2 has 28, so n times it is exact, and so is the difference from x; the second part costs u |r|.
/// Horner's rule costs at most 2 u 1.42 |r|^k in step k: in all 4.4 u, and e^r >= .707. The rest of the series is 6e-18.
/// The sum is below 8 u = 2^-50.
inline double exp_in_double(double x)
{
    double const shifted = x * 1.4426950408889634 + 0x1.8p52;
    double const n = shifted - 0x1.8p52;
    double const r = (x - n * 0x1.62e42fep-1) - n * 0x1.f473de6af278fp-30;
    double p = 1.0 / 6227020800;
    p = p * r + 1.0 / 479001600, p = p * r + 1.0 / 39916800, p = p * r + 1.0 / 3628800;
    p = p * r + 1.0 / 362880, p = p * r + 1.0 / 40320, p = p * r + 1.0 / 5040;
    p = p * r + 1.0 / 720, p = p * r + 1.0 / 120, p = p * r + 1.0 / 24;
    p = p * r + 1.0 / 6, p = p * r + 0.5, p = p * r + 1.0, p = p * r + 1.0;
    return __builtin_bit_cast(double,
                              static_cast<std::uint64_t>(__builtin_bit_cast(std::uint64_t, p) + (__builtin_bit_cast(std::uint64_t, shifted) << 52)));
}

// --- 2. a splat in double ----------------------------------------------------------------------------------------------
struct Rounded {
    double v, e;
};
inline Rounded round_to_double(Ball const& b)
{
    auto const v = static_cast<double>(b.v);
    return {v, up(size_of(b.v - Quad(v)) + b.r)};
}

/// Sets the double splat and rho. u = 2^-53. P bounds |power| at pixels that alpha_min does not cut. With DX = sqrt(P / |along|), OFF =
/// sqrt(P / |across|) and DY = OFF + |slope| DX, a lit pixel has |dx| <= DX, |off| <= OFF, |dy| <= DY. Then
///   |d dx| <= err(x) + u DX,  |d dy| <= err(y) + u DY,
///   |d off| <= |d dy| + |slope| |d dx| + (DX + |d dx|) err(slope) + u (OFF + |slope| DX),
///   |d power| <= |along| (2 DX |d dx| + |d dx|^2) + err(along) DX^2 + the same of across, + 3 u P for its own operations.
/// alpha = opacity e^power: relative e^|d power| - 1, err(opacity) / opacity, 2^-49 for `exp_in_double`, u for the product. The constants are
/// rounded up by 2 %, which the second orders and the rounding of these sums do not reach while rho < .01. False for a larger rho.
inline bool round_splat(DoubleSplat& e, BallSplat const& b, splat::Rules const& rules)
{
    constexpr double u = 0x1p-53;
    auto const x = round_to_double(b.x), y = round_to_double(b.y), along = round_to_double(b.along), slope = round_to_double(b.slope),
               across = round_to_double(b.across), opacity = round_to_double(b.opacity);
    e.x = x.v, e.y = y.v, e.along = along.v, e.slope = slope.v, e.across = across.v, e.opacity = opacity.v;
    e.colour_error = 0;
    for (int k = 0; k < 3; ++k) {
        auto const c = round_to_double(b.colour[k]);
        e.colour[k] = c.v, e.colour_error = std::max(e.colour_error, c.e);
    }
    double const most = std::max(0.0, std::log(e.opacity / double{rules.alpha_min})) + 0.1;
    double const a = std::fabs(e.along) * (1 - 1e-10), c = std::fabs(e.across) * (1 - 1e-10), k = std::fabs(e.slope) * (1 + 1e-10);
    double const dx = std::sqrt(most / a), off = std::sqrt(most / c), dy = off + k * dx;
    double const ddx = x.e + u * dx * 1.01, ddy = y.e + u * dy * 1.01;
    double const doff = ddy + k * ddx + (dx + ddx) * slope.e + 1.01 * u * (off + k * dx);
    double const dp =
        a * 1.01 * (2 * dx * ddx + ddx * ddx) + along.e * dx * dx + c * 1.01 * (2 * off * doff + doff * doff) + across.e * off * off + 5 * u * most;
    e.rho = 1.02 * (std::expm1(1.02 * dp) + 1.01 * opacity.e / e.opacity + 0x1p-49 + 2 * u);
    return e.rho < 0.01;
}

inline std::int32_t pixel_of(double v, std::uint32_t size)
{
    return static_cast<std::int32_t>(std::clamp(v, 0.0, static_cast<double>(size)));
}

/// Sets the pixels that the rules' footprint may and must have. `t`: the half-width of the ellipse alpha = alpha_min in standard deviations.
inline void set_footprint(DoubleSplat& e, BallSplat const& b, splat::Camera const& c, splat::Rules const& rules, double t)
{
    // The box of that ellipse, outward: pixels outside are cut by alpha_min anyway.
    double const hx = t * std::sqrt(upper(b.xx)) * (1 + 1e-9), hy = t * std::sqrt(upper(b.yy)) * (1 + 1e-9);
    e.may = {pixel_of(std::floor(lower(b.x) - hx - 0.51), c.width), pixel_of(std::floor(upper(b.x) + hx + 0.51) + 1, c.width),
             pixel_of(std::floor(lower(b.y) - hy - 0.51), c.height), pixel_of(std::floor(upper(b.y) + hy + 0.51) + 1, c.height)};
    e.must = e.may;
    if (rules.footprint == splat::Footprint::opacity_box) return;
    bool const tiles = rules.footprint == splat::Footprint::three_sigma_tiles;
    Ball const half = Ball(0.5) * (b.xx - b.yy), mid = Ball(0.5) * (b.xx + b.yy), off = b.slope * b.xx;
    Ball squared = half * half + off * off;
    if (tiles) squared = larger(squared, Ball(Quad(1) / Quad(10), 1e-33)); // the rasteriser's
    Ball const three_sigma = Ball(3) * root(mid + root(squared));
    double const least = std::ceil(lower(three_sigma)), greatest = std::ceil(upper(three_sigma));
    auto const span = [&](Ball const& mean, double radius, std::uint32_t size, bool inner) -> std::pair<std::int32_t, std::int32_t> {
        Ball first = mean - Ball(radius), last = mean + Ball(radius);
        if (tiles) first = (first - Ball(0.5)) / Ball(16), last = (last + Ball(14.5)) / Ball(16);
        double const from = std::floor(inner ? upper(first) : lower(first)), to = std::floor(inner ? lower(last) : upper(last));
        if (tiles) return {pixel_of(16 * from, size), pixel_of(16 * to, size)};
        return {pixel_of(from, size), pixel_of(to + 1, size)};
    };
    auto const ox = span(b.x, greatest, c.width, false), oy = span(b.y, greatest, c.height, false);
    auto const ix = span(b.x, least, c.width, true), iy = span(b.y, least, c.height, true);
    e.may = {std::max(e.may.x0, ox.first), std::min(e.may.x1, ox.second), std::max(e.may.y0, oy.first), std::min(e.may.y1, oy.second)};
    e.must = {ix.first, ix.second, iy.first, iy.second};
}

/// Is a record drawn by the kernels at all? Its numbers are finite, but for a logarithm of a size of 0, and colours are at most 1e6.
inline bool is_drawable(EnclosedRecord const& record)
{
    auto const& g = *record.gaussian;
    auto const finite = [](auto const& values) {
        return std::all_of(std::begin(values), std::end(values), [](float v) { return std::isfinite(v); });
    };
    bool all = finite(g.mean_world) && finite(g.colour) && finite(g.rotation) && std::isfinite(g.opacity);
    for (float const v : g.log_scale) all = all && v < std::numeric_limits<float>::infinity();
    for (float const v : g.colour) all = all && std::fabs(v) <= 1e6f;
    for (std::uint32_t i = 0; i < 3 * splat::harmonics_per_channel(record.degree); ++i) all = all && std::isfinite(record.harmonics[i]);
    return all;
}

/// Calls f(i) for 0 <= i < n, on some threads, in any order. Rethrows nothing: f does not throw.
template <class F>
void for_each_on(unsigned threads, std::size_t n, F const& f)
{
    std::atomic<std::size_t> next{0};
    auto const work = [&]() noexcept {
        for (std::size_t i; (i = next.fetch_add(1, std::memory_order_relaxed)) < n;) f(i);
    };
    JoinedThreads workers;
    for (unsigned k = 1; k < threads && k < n; ++k) workers.start(work);
    work();
}

/// All splats that may light a pixel, in the exact order: depth, then id.
struct EnclosedSplats {
    std::vector<DoubleSplat> splats;
    std::vector<BallSplat> balls; ///< of the same place as `splats`
    std::vector<std::size_t> not_enclosed;
};
inline EnclosedSplats project_all(std::span<EnclosedRecord const> records, splat::Camera const& c, splat::Rules const& rules, unsigned threads)
{
    struct Projected {
        DoubleSplat splat{};
        BallSplat ball;
        bool visible = false, enclosed = true;
    };
    float const near_depth = rules.near_plane == splat::NearPlane::fixed ? splat::fixed_near_depth : c.near_depth;
    std::vector<std::uint32_t> seen; // both decisions are exact
    for (std::size_t i = 0; i < records.size(); ++i) {
        auto const& g = *records[i].gaussian;
        if (is_drawable(records[i]) && g.opacity >= rules.alpha_min && depth_sign(c, g, near_depth) > 0)
            seen.push_back(static_cast<std::uint32_t>(i));
    }
    std::vector<Projected> all(seen.size());
    for_each_on(threads, all.size(), [&](std::size_t i) {
        auto const& record = records[seen[i]];
        auto& out = all[i];
        bool small = true; // `exponential` takes no more
        for (float const v : record.gaussian->log_scale) small = small && std::fabs(v) <= 100;
        auto const ball = small ? project_in_balls(record, c, rules) : std::nullopt;
        out.enclosed = ball.has_value();
        if (!ball) return;
        out.ball = *ball;
        out.splat.record = seen[i];
        if (upper(ball->opacity) < double{rules.alpha_min}) return;
        if (!round_splat(out.splat, *ball, rules)) out.splat.rho = std::numeric_limits<double>::infinity();
        double const t = std::sqrt(2 * std::max(0.0, std::log(upper(ball->opacity) / double{rules.alpha_min})) + 1e-12) * (1 + 1e-12);
        set_footprint(out.splat, *ball, c, rules, t);
        out.visible = !out.splat.may.empty();
    });
    EnclosedSplats out;
    std::vector<std::uint32_t> order;
    std::vector<double> z(all.size()), error(all.size()); // the depths in double decide unless they are close
    for (std::uint32_t i = 0; i < all.size(); ++i) {
        if (!all[i].enclosed) out.not_enclosed.push_back(seen[i]);
        if (!all[i].visible) continue;
        order.push_back(i);
        for (int k = 0; k < 3; ++k) {
            double const p = double{c.rotation[2][k]} * double{records[seen[i]].gaussian->mean_world[k]};
            z[i] += p, error[i] += std::fabs(p);
        }
        error[i] *= 0x1p-50;
    }
    std::sort(order.begin(), order.end(), [&](std::uint32_t p, std::uint32_t q) {
        if (std::fabs(z[p] - z[q]) > error[p] + error[q]) return z[p] < z[q];
        auto const &a = *records[seen[p]].gaussian, &b = *records[seen[q]].gaussian;
        int const nearer = compare_depth(c, a, b);
        return nearer != 0 ? nearer < 0 : a.id < b.id;
    });
    for (auto const i : order) out.splats.push_back(all[i].splat), out.balls.push_back(all[i].ball);
    return out;
}

// --- 3. and 4. blending in double ---------------------------------------------------------------------------------------
inline constexpr int block_px = 16; ///< side of the blocks of pixels that have one list of splats

/// A row of a block: transmittance, colours, the sum of errors, 1 where a decision is doubtful, 1 where the pixel goes on.
struct BoundedRow {
    double t[block_px], c[3][block_px], s[block_px], doubtful[block_px], open[block_px];
};

/// Blends one splat into the row j of the block at (px, py). It has no branches, so that a compiler can use vectors.
inline void blend_row(BoundedRow& row, DoubleSplat const& e, int px, int py, int j, splat::Rules const& rules)
{
    constexpr double u4 = 0x1p-51;
    double const cut = rules.alpha_min, most = rules.alpha_max, limit = rules.transmittance_min;
    double const drops = rules.stop == splat::Stop::before_crossing ? 1.0 : 0.0;
    double const x0 = e.may.x0 - px, x1 = e.may.x1 - px, m0 = e.must.x0 - px, m1 = e.must.x1 - px;
    double const row_must = py + j >= e.must.y0 && py + j < e.must.y1 ? 1.0 : 0.0;
    double const dy = py + j + 0.5 - e.y, wild = e.rho < 1 ? 0.0 : 1.0, rho = e.rho < 1 ? e.rho : 0.0;
    for (int i = 0; i < block_px; ++i) {
        double const t = row.t[i], open = row.open[i];
        double const dx = px + i + 0.5 - e.x;
        double const off = dy - e.slope * dx;
        double power = e.along * dx * dx + e.across * off * off;
        power = power > -600 ? power : -600;
        double const a0 = e.opacity * exp_in_double(power);
        double const at = i; // comparisons of doubles alone
        double const inside = (at >= x0 ? 1.0 : 0.0) * (at < x1 ? 1.0 : 0.0) * open;
        double const must = (at >= m0 ? 1.0 : 0.0) * (at < m1 ? 1.0 : 0.0) * row_must;
        double const in0 = (a0 >= cut ? 1.0 : 0.0) * inside;
        double const a = a0 < most ? a0 : most;
        double const w0 = a * t, behind = t - w0;
        double const crosses = (behind < limit ? in0 : 0.0) * drops;
        double const in = in0 - crosses, w = w0 * in, after = t - w;
        for (int k = 0; k < 3; ++k) row.c[k][i] += w * e.colour[k];
        double const d = a0 * rho;
        double const gap = a0 > cut ? a0 - cut : cut - a0;
        double const near = gap <= d ? 1.0 : 0.0, beside = a0 >= cut - d ? 1.0 - must : 0.0;
        double const flips = (near + beside + wild > 0 ? 1.0 : 0.0) * inside;
        double const size = wild > 0 ? 1.0 : a0 + d; // no alpha is larger than 1
        double s = row.s[i] + in * (t * d + u4) + flips * t * size;
        double const seen = drops > 0 ? behind : after;
        double const away = seen > limit ? seen - limit : limit - seen;
        double const there = drops > 0 ? in0 : in; // a term that may be there may be the last one
        double const stops = away <= s * 1.000001 + t * (d + u4) ? (there > flips ? there : flips) : 0.0;
        s += stops * (drops > 0 ? t : after) * 1.01;
        row.s[i] = s;
        row.doubtful[i] = flips + stops > 0 ? 1.0 : row.doubtful[i];
        row.open[i] = drops > 0 ? open - crosses : (after < limit ? 0.0 : open);
        row.t[i] = after;
    }
}

// --- 5. a pixel in balls ------------------------------------------------------------------------------------------------
/// Where balls do not decide either, both outcomes are enclosed: a term is the hull of 0 and itself; a stop adds the picture so far to a
/// hull, and the pixel goes on. By induction over the terms, each execution of exact real arithmetic either stops at a term whose picture is in
/// the hull, or is enclosed by the state that goes on.
inline Enclosure::Decided blend_pixel(Ball (&colour)[3], std::int32_t x, std::int32_t y, EnclosedSplats const& p, std::span<std::uint32_t const> list,
                                      splat::Rules const& rules)
{
    Ball t = 1, c[3], hulls[3];
    bool have_hull = false, stopped = false;
    auto decided = Enclosure::Decided::in_quad;
    bool const drops = rules.stop == splat::Stop::before_crossing;
    auto const keep = [&] {
        for (int k = 0; k < 3; ++k) {
            Ball const now = c[k] + t * Ball(rules.background[k]);
            hulls[k] = have_hull ? hull(hulls[k], now) : now;
        }
        have_hull = true;
    };
    for (std::uint32_t const n : list) {
        DoubleSplat const& e = p.splats[n];
        if (!e.may.contains(x, y)) continue;
        if (e.rho < 1) { // certainly cut?
            double const dx = x + 0.5 - e.x, off = y + 0.5 - e.y - e.slope * dx;
            double const a = e.opacity * exp_in_double(std::max(-600.0, e.along * dx * dx + e.across * off * off));
            if (a * (1 + 2 * e.rho) < double{rules.alpha_min}) continue;
        }
        BallSplat const& b = p.balls[n];
        Ball const dx = Ball(x + 0.5) - b.x, off = Ball(y + 0.5) - b.y - b.slope * dx;
        Ball power = b.along * dx * dx + b.across * off * off;
        if (upper(power) < -90) continue; // e^-90 is 8e-40, and alpha_min at least 1e-30
        Ball a;
        if (lower(power) > -99) {
            a = exponential(Ball(power.v < 0 ? power.v : Quad(0), 0));
            double const wide = power.v < 0 ? power.r : power.r + size_of(power.v);
            a = b.opacity * Ball(a.v, up(a.r + size_of(a.v) * up(std::expm1(up(wide)))));
        } else {
            a = Ball(0.5, 0.5) * b.opacity; // a ball as large as this says nothing
        }
        if (lower(a) < 0 || upper(a) > upper(b.opacity)) a = larger(Ball(0), smaller(a, b.opacity));
        auto const visible = sign(a - Ball(rules.alpha_min));
        if (visible && *visible < 0) continue;
        a = smaller(a, Ball(rules.alpha_max));
        if (!visible || !e.must.contains(x, y)) a = hull(a, Ball(0)), decided = Enclosure::Decided::undecided;
        Ball const w = a * t, behind = t - w;
        auto const stops = sign(behind - Ball(rules.transmittance_min));
        if (drops && stops && *stops < 0) {
            stopped = true, keep();
            break;
        }
        if (drops && !stops) keep(), decided = Enclosure::Decided::undecided;
        for (int k = 0; k < 3; ++k) c[k] = c[k] + w * b.colour[k];
        t = behind;
        if (!drops && stops && *stops < 0) {
            stopped = true, keep();
            break;
        }
        if (!drops && !stops) keep(), decided = Enclosure::Decided::undecided;
    }
    if (!stopped) keep();
    for (int k = 0; k < 3; ++k) colour[k] = hulls[k];
    return decided;
}

/// Encloses the pixels of one block.
inline void enclose_block(Enclosure& out, int px, int py, EnclosedSplats const& p, std::span<std::uint32_t const> list, splat::Rules const& rules)
{
    BoundedRow rows[block_px];
    for (auto& row : rows)
        for (int i = 0; i < block_px; ++i) row.t[i] = row.open[i] = 1, row.c[0][i] = row.c[1][i] = row.c[2][i] = row.s[i] = row.doubtful[i] = 0;
    double spread[3], colour_error = 0;
    for (int k = 0; k < 3; ++k) {
        double low = rules.background[k], high = low;
        for (auto const n : list) low = std::min(low, p.splats[n].colour[k]), high = std::max(high, p.splats[n].colour[k]);
        spread[k] = std::max({high - low, high, -low}) * 1.000001;
    }
    for (std::size_t n = 0; n < list.size(); ++n) {
        if (n % 32 == 31 && std::none_of(std::begin(rows), std::end(rows), [](BoundedRow const& row) {
                return std::any_of(std::begin(row.open), std::end(row.open), [](double open) { return open > 0; });
            }))
            break;
        auto const& e = p.splats[list[n]];
        colour_error = std::max(colour_error, e.colour_error);
        for (int j = std::max(e.may.y0 - py, 0); j < std::min(e.may.y1 - py, block_px); ++j) blend_row(rows[j], e, px, py, j, rules);
    }
    for (int j = 0; j < block_px && static_cast<std::uint32_t>(py + j) < out.height; ++j)
        for (int i = 0; i < block_px && static_cast<std::uint32_t>(px + i) < out.width; ++i) {
            auto const at = std::size_t{out.width} * static_cast<std::uint32_t>(py + j) + static_cast<std::uint32_t>(px + i);
            auto const& row = rows[j];
            for (int k = 0; k < 3; ++k) {
                out.middle[3 * at + static_cast<std::size_t>(k)] = row.c[k][i] + row.t[i] * double{rules.background[k]};
                // The weights of a pixel sum to at most 1 + S.
                out.radius[3 * at + static_cast<std::size_t>(k)] = spread[k] * (row.s[i] * 1.000001 + 0x1p-50) + colour_error * (1.000001 + row.s[i]);
            }
            if (row.doubtful[i] == 0) continue;
            Ball c[3];
            out.decided[at] = blend_pixel(c, px + i, py + j, p, list, rules);
            for (int k = 0; k < 3; ++k) { // the narrower one of the two
                auto const [m, r] = round_to_double(c[k]);
                auto const channel = 3 * at + static_cast<std::size_t>(k);
                if (r < out.radius[channel]) out.middle[channel] = m, out.radius[channel] = r;
            }
        }
}

TILEMESH_HOST Enclosure enclose(std::span<EnclosedRecord const> records, splat::Camera const& camera, splat::Rules const& rules, unsigned threads)
{
    if (!(rules.alpha_min >= 1e-30f))
        throw Error("an enclosure for an alpha_min of " + significant(double{rules.alpha_min}, 3) +
                    " (each record lights each pixel, in what a double cannot tell from nothing); give one of 1e-30 or more");
    auto const p = project_all(records, camera, rules, threads);
    Enclosure out{camera.width, camera.height, {}, {}, {}, p.splats.size(), p.not_enclosed};
    auto const pixels = std::size_t{camera.width} * camera.height;
    out.middle.resize(3 * pixels), out.radius.resize(3 * pixels), out.decided.resize(pixels, Enclosure::Decided::in_double);
    auto const columns = (camera.width + block_px - 1) / block_px, rows = (camera.height + block_px - 1) / block_px;
    std::vector<std::vector<std::uint32_t>> lists(std::size_t{columns} * rows); // front to back
    for (std::uint32_t n = 0; n < p.splats.size(); ++n) {
        auto const& may = p.splats[n].may;
        for (int y = may.y0 / block_px; y <= (may.y1 - 1) / block_px; ++y)
            for (int x = may.x0 / block_px; x <= (may.x1 - 1) / block_px; ++x)
                lists[std::size_t{columns} * static_cast<std::uint32_t>(y) + static_cast<std::uint32_t>(x)].push_back(n);
    }
    for_each_on(threads, lists.size(), [&](std::size_t at) {
        auto const x = static_cast<int>(at % columns), y = static_cast<int>(at / columns);
        enclose_block(out, x * block_px, y * block_px, p, lists[at], rules);
    });
    return out;
}
#else
TILEMESH_HOST Enclosure enclose(std::span<EnclosedRecord const>, splat::Camera const&, splat::Rules const&, unsigned)
{
    throw Error("no enclosure on this host (it has no numbers of 113 bits, or rounds doubles twice); take x86-64 or 64-bit ARM");
}
#endif

}}} // namespace tilemesh::v0_2::report::detail

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST std::uint64_t Enclosure::count(Decided how) const noexcept
{
    return static_cast<std::uint64_t>(std::count(decided.begin(), decided.end(), how));
}
TILEMESH_HOST double Enclosure::widest() const noexcept
{
    return radius.empty() ? 0.0 : 2 * *std::max_element(radius.begin(), radius.end());
}

TILEMESH_HOST Certificate certify(Enclosure const& enclosure, Image const& picture, Written const& written)
{
    if (picture.width != enclosure.width || picture.height != enclosure.height)
        throw Error("a picture of " + std::to_string(picture.width) + " x " + std::to_string(picture.height) + " pixels (the enclosure has " +
                    std::to_string(enclosure.width) + " x " + std::to_string(enclosure.height) + "); take the picture of this camera");
    Certificate out;
    std::vector<double> off(picture.rgb.size()), of_pixel(off.size() / 3);
    for (std::size_t i = 0; i < off.size(); ++i) {
        // To clamp brings no two values farther apart. The first rounding is of 2^-53 of the difference, and the others of that of the result.
        double const middle = written.clamped ? std::clamp(enclosure.middle[i], 0.0, 1.0) : enclosure.middle[i];
        double const apart = std::fabs(double{picture.rgb[i]} - middle), away = apart + 0x1p-52 * apart - written.half_step;
        double const levels = ((away < 0 ? 0.0 : away) + enclosure.radius[i]) * 255 * (1 + 0x1p-50);
        off[i] = std::isnan(levels) ? std::numeric_limits<double>::infinity() : levels;
        of_pixel[i / 3] = std::max(of_pixel[i / 3], off[i]);
    }
    if (off.empty()) return out;
    auto const quantile = [&](std::vector<double>& values, double q) {
        auto const at = values.begin() + static_cast<std::ptrdiff_t>(std::ceil(q * static_cast<double>(values.size() - 1)));
        std::nth_element(values.begin(), at, values.end());
        return *at;
    };
    out.largest = quantile(off, 1.0), out.p99 = quantile(off, 0.99), out.median = quantile(off, 0.5);
    std::vector<std::uint32_t> places;
    for (std::uint32_t i = 0; i < of_pixel.size(); ++i)
        if (of_pixel[i] > 0.01) places.push_back(i);
    out.beyond = places.size();
    auto const shown = std::min<std::size_t>(10, places.size());
    std::partial_sort(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(shown), places.end(),
                      [&](std::uint32_t a, std::uint32_t b) { return of_pixel[a] != of_pixel[b] ? of_pixel[a] > of_pixel[b] : a < b; });
    for (std::size_t i = 0; i < shown; ++i) out.worst.push_back({places[i] % picture.width, places[i] / picture.width, of_pixel[places[i]]});
    return out;
}

TILEMESH_HOST std::string text_of(Certificate const& c, Enclosure const& e)
{
    // One unit of the third digit more than the nearest three digits is not below the number.
    auto const shown = [](double levels) { return levels > 0 && std::isfinite(levels) ? significant(levels * 1.01, 3) : significant(levels, 3); };
    using Decided = Enclosure::Decided;
    auto text = "every channel within " + shown(c.largest) + "/255 of the exact formula (p99 " + shown(c.p99) + ", median " + shown(c.median) + "; " +
                std::to_string(c.beyond) + " pixels beyond 0.01; " + std::to_string(e.count(Decided::in_quad)) + " decided in 113 bits, " +
                std::to_string(e.count(Decided::undecided)) + " undecided)";
    if (!e.not_enclosed.empty())
        text += "; NOT for the whole map: no interval encloses " + std::to_string(e.not_enclosed.size()) + " records, the first is row " +
                std::to_string(e.not_enclosed.front());
    return text;
}

}}} // namespace tilemesh::v0_2::report
TILEMESH_EXACT_END
