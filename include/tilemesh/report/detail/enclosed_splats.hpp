#pragma once
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <tilemesh/joined_threads.hpp>
#include <tilemesh/report/detail/ball.hpp>
#include <tilemesh/report/detail/enclosed_record.hpp>
#include <tilemesh/report/detail/large_memory.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/rules.hpp>
#include <utility>
#include <vector>

#if TILEMESH_HAS_BALLS
TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace report::detail {

// The first two steps of an enclosure (enclosure.hpp): splats of the exact formula in balls and in double, in the exact order.

// --- 1. projection ------------------------------------------------------------------------------------------------------
/// A splat of the exact formula: mean in pixels, power = along dx^2 + across (dy - slope dx)^2, and the covariance's xx and yy.
struct BallSplat {
    Ball x, y, z, along, slope, across, xx, yy, opacity, colour[3];
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
    double colour[4], colour_error, depth_error; ///< the fourth colour is the depth
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

/// pi: the double nearest to it and the rest, whose own error is below 2^-108.
inline Ball pi_ball()
{
    return {Wide(3.141592653589793116, 1.2246467991473532e-16), 1e-31};
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
    out.z = z;
    out.xx = sharp_xx + h, out.yy = sharp_yy + h;
    Ball const determinant = sharp + h * (sharp_xx + sharp_yy) + h * h;
    out.x = Ball(c.fx) * sx + Ball(c.cx), out.y = Ball(c.fy) * sy + Ball(c.cy);
    out.along = Ball(-0.5) / out.xx, out.slope = dot(v1, v2) / out.xx, out.across = Ball(-0.5) * out.xx / determinant;
    out.opacity = std::min(g.opacity, 1.0f);
    if (rules.coverage == splat::Coverage::preserved) {
        Ball const least = Ball(25) / Ball(1000000);
        out.opacity = out.opacity * root(larger(least, sharp / determinant));
    }
    set_colour(out, record, d);
    bool finite = lower(determinant) > 0 && lower(out.xx) > 0 && lower(out.yy) > 0 && is_finite(determinant);
    for (Ball const* b : {&out.x, &out.y, &out.z, &out.along, &out.slope, &out.across, &out.xx, &out.yy, &out.opacity, &out.colour[0], &out.colour[1],
                          &out.colour[2]})
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
    return {b.v.hi, up(std::fabs(b.v.lo) + b.r)};
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
    auto const z = round_to_double(b.z);
    e.colour[3] = z.v, e.depth_error = z.e;
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
    return v > 0 ? static_cast<std::int32_t>(std::min(v, static_cast<double>(size))) : 0;
}

/// Sets the pixels that the rules' footprint may and must have. `t`: the half-width of the ellipse alpha = alpha_min in standard deviations. False
/// if no ball encloses the footprint.
inline bool set_footprint(DoubleSplat& e, BallSplat const& b, splat::Camera const& c, splat::Rules const& rules, double t)
{
    // The box of that ellipse, outward: pixels outside are cut by alpha_min anyway.
    double const hx = t * std::sqrt(upper(b.xx)) * (1 + 1e-9), hy = t * std::sqrt(upper(b.yy)) * (1 + 1e-9);
    e.may = {pixel_of(std::floor(lower(b.x) - hx - 0.51), c.width), pixel_of(std::floor(upper(b.x) + hx + 0.51) + 1, c.width),
             pixel_of(std::floor(lower(b.y) - hy - 0.51), c.height), pixel_of(std::floor(upper(b.y) + hy + 0.51) + 1, c.height)};
    e.must = e.may;
    if (rules.footprint == splat::Footprint::opacity_box) return true;
    bool const tiles = rules.footprint == splat::Footprint::three_sigma_tiles;
    Ball const half = Ball(0.5) * (b.xx - b.yy), mid = Ball(0.5) * (b.xx + b.yy), off = b.slope * b.xx;
    Ball squared = half * half + off * off;
    if (tiles) squared = larger(squared, Ball(1) / Ball(10)); // the rasteriser's
    Ball const three_sigma = Ball(3) * root(mid + root(squared));
    if (!is_finite(three_sigma)) return false;
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
    return true;
}

/// Is a record drawn by the kernels at all? Its numbers are finite, but for a logarithm of a size of 0, colours are at most 1e6, and the
/// quaternion has a direction.
inline bool is_drawable(EnclosedRecord const& record)
{
    auto const& g = *record.gaussian;
    auto const finite = [](auto const& values) {
        return std::all_of(std::begin(values), std::end(values), [](float v) { return std::isfinite(v); });
    };
    bool all = finite(g.mean_world) && finite(g.colour) && finite(g.rotation) && std::isfinite(g.opacity);
    all = all && std::any_of(std::begin(g.rotation), std::end(g.rotation), [](float q) { return q != 0; });
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
    std::vector<std::uint64_t> not_enclosed; ///< ids
    double spread = 0; ///< no smaller than the difference of two colours, or of a colour and 0, of records in front of the camera
};
/// What an enclosure keeps: the picture can be looked at again.
struct EnclosedScene {
    EnclosedSplats splats;
    splat::Rules rules;                 ///< with which it was blended
    std::vector<splat::GaussianId> ids; ///< of `splats`
    /// For each block of 16 x 16 pixels, row by row, the splats that may light it, front to back.
    std::vector<std::vector<std::uint32_t>> lists;
    std::uint32_t columns = 0; ///< blocks in a row
};
/// `least_opacity`: records below are left out at once.
inline EnclosedSplats project_all(std::span<EnclosedRecord const> records, splat::Camera const& c, splat::Rules const& rules, float least_opacity,
                                  unsigned threads)
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
        if (is_drawable(records[i]) && g.opacity >= least_opacity && depth_sign(c, g, near_depth) > 0) seen.push_back(static_cast<std::uint32_t>(i));
    }
    std::vector<Projected> all;
    resize_large(all, seen.size());
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
        out.enclosed = set_footprint(out.splat, *ball, c, rules, t);
        out.visible = out.enclosed && !out.splat.may.empty();
    });
    EnclosedSplats out;
    std::vector<std::uint32_t> order;
    double least = 0, greatest = 0;
    std::vector<double> z(all.size()), error(all.size()); // the depths in double decide unless they are close
    for (std::uint32_t i = 0; i < all.size(); ++i) {
        if (!all[i].enclosed) {
            out.not_enclosed.push_back(static_cast<std::uint32_t>(records[seen[i]].gaussian->id));
            continue;
        }
        for (auto const& colour : all[i].ball.colour) least = std::min(least, lower(colour)), greatest = std::max(greatest, upper(colour));
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
    for (float const b : rules.background) least = std::min(least, double{b}), greatest = std::max(greatest, double{b});
    out.spread = (greatest - least) * 1.000001;
    resize_large(out.splats, order.size()), resize_large(out.balls, order.size());
    for (std::size_t n = 0; n < order.size(); ++n) out.splats[n] = all[order[n]].splat, out.balls[n] = all[order[n]].ball;
    return out;
}

}}} // namespace tilemesh::report::detail
TILEMESH_EXACT_END
#endif
