#pragma once
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <tilemesh/splat/depth_key.hpp>
#include <tilemesh/splat/bend.hpp>
#include <tilemesh/splat/exponential.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/logarithm.hpp>
#include <tilemesh/splat/number.hpp>
#include <tilemesh/splat/view.hpp>
#include <type_traits>

TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // the functions are always inlined, so it does not matter how a wide vector is passed
namespace tilemesh { inline namespace v0_2 { namespace splat {

/// A Gaussian on the screen: the 56 bytes that compositing needs. It is invisible if its rectangle is empty.
///
/// The 2-D mean is in pixels, relative to the principal point. An absolute coordinate would lose digits that the distance to a pixel centre
/// needs: rho, the error of alpha relative to the error that its inputs' last bits excuse, would be 21 instead of 1.5 (measured;
/// tests/stability/rho.cpp). The dilated covariance (a b; b c) is kept as the LDL^T form of its inverse: power = along dx^2 + across (dy -
/// slope dx)^2. Both factors are negative, so rounding cannot make the power positive.
struct Splat {
    float mean_px[2];
    float along;             ///< -1 / (2 a)
    float slope;             ///< b / a
    float across;            ///< -a / (2 (a c - b^2))
    float opacity;
    float colour[3];
    std::uint32_t depth_key; ///< rises with the view depth (depth_key.hpp); not 0 if visible
    float faintest;          ///< the power below which alpha is under alpha_min, with a margin of 1 %
    std::uint32_t columns;   ///< x0 | x1 << 16; pixels outside get nothing from this splat, on every tile
    std::uint32_t rows;      ///< y0 | y1 << 16
    TileId anchor;           ///< the tile of its mean; a mean outside the rectangle is moved to the rectangle's nearest pixel

    float depth() const noexcept { return depth_of_key(depth_key); } ///< view z; at least near
    bool visible() const noexcept { return columns != 0; } // x1 is at least 1 if a pixel is visible
    PixelRect rect() const noexcept { return {columns & 0xffffu, columns >> 16, rows & 0xffffu, rows >> 16}; }
};
static_assert(sizeof(Splat) == 56 && std::is_trivially_copyable_v<Splat>, "a splat is 14 words");

/// The largest valid colour. A larger one is from a broken record, and would spread as infinity or NaN. Real maps reach 3.8.
inline constexpr float largest_colour = 1e6f;

namespace detail {
using Float3 = Vector3<OneFloat>;

template <class A>
TILEMESH_KERNEL Vector3<A> cross(Vector3<A> const& a, Vector3<A> const& b) noexcept
{
    return {A::multiply_add(a.y, b.z, -(a.z * b.y)), A::multiply_add(a.z, b.x, -(a.x * b.z)), A::multiply_add(a.x, b.y, -(a.y * b.x))};
}

template <class A>
TILEMESH_KERNEL typename A::Real squared_length(typename A::Real const& w, typename A::Real const& x, typename A::Real const& y,
                                                typename A::Real const& z) noexcept
{
    return A::multiply_add(w, w, A::multiply_add(x, x, A::multiply_add(y, y, z * z)));
}

/// The largest power of two that is not above v > 0, clamped to [2^-126, 2^126]. Its inverse is a power of two as well.
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

/// The Gaussian's axes: the columns of R from a quaternion of any length. A quaternion whose square leaves the range of floats is scaled first;
/// lanes do not, and say where they would have to.
template <class A>
TILEMESH_KERNEL typename A::Mask axes_of(typename A::Real const (&rotation)[4], Vector3<A> (&axis)[3]) noexcept
{
    using Real = typename A::Real;
    typename A::Mask stiff{};
    Real qw = rotation[0], qx = rotation[1], qy = rotation[2], qz = rotation[3];
    Real norm = squared_length<A>(qw, qx, qy, qz);
    if constexpr (A::lanes > 1) {
        stiff = A::negation(A::every(norm > A::all(1e-30f), norm < A::all(1e30f)));
    } else if (!(norm > 1e-30f && norm < 1e30f)) {
        float largest = 0;
        for (float const v : rotation) largest = std::fabs(v) > largest ? std::fabs(v) : largest;
        float const shrink = inverse_of_power(power_of_two_below(largest));
        qw *= shrink, qx *= shrink, qy *= shrink, qz *= shrink;
        norm = squared_length<A>(qw, qx, qy, qz);
    }
    Real const two = A::all(2.0f) / norm, one = A::all(1.0f);
    Real const xx = two * qx * qx, yy = two * qy * qy, zz = two * qz * qz;
    Real const xy = two * qx * qy, xz = two * qx * qz, yz = two * qy * qz;
    Real const wx = two * qw * qx, wy = two * qw * qy, wz = two * qw * qz;
    axis[0] = {one - (yy + zz), xy + wz, xz - wy};
    axis[1] = {xy - wz, one - (xx + zz), yz + wx};
    axis[2] = {xz + wy, yz - wx, one - (xx + yy)};
    return stiff;
}

/// The factor V = J W R S and its covariance V V^T. `axis[i]` are the columns of W R in view space.
template <class A>
struct Factor {
    using Real = typename A::Real;
    Vector3<A> axis[3];
    Real jx, jy;             ///< the Jacobian's slopes
    Real px_per_x, px_per_y; ///< focal length over depth
    Vector3<A> row1, row2;   ///< of V
    Real a, b, c;            ///< V V^T
    Real determinant;        ///< of V V^T: |v1 x v2|^2, never a c - b^2

    TILEMESH_KERNEL void multiply(Vector3<A> const& scale) noexcept
    {
        row1 = {entry(px_per_x, scale.x, jx, axis[0].z, axis[0].x), entry(px_per_x, scale.y, jx, axis[1].z, axis[1].x),
                entry(px_per_x, scale.z, jx, axis[2].z, axis[2].x)};
        row2 = {entry(px_per_y, scale.x, jy, axis[0].z, axis[0].y), entry(px_per_y, scale.y, jy, axis[1].z, axis[1].y),
                entry(px_per_y, scale.z, jy, axis[2].z, axis[2].y)};
        finish();
    }
    /// The same for a lens that bends.
    TILEMESH_KERNEL void multiply(Vector3<A> const& scale, Bent<A> const& bent) noexcept
    {
        Vector3<A> const p{scale.x * dot(bent.across, axis[0]), scale.y * dot(bent.across, axis[1]), scale.z * dot(bent.across, axis[2])};
        Vector3<A> const q{scale.x * dot(bent.down, axis[0]), scale.y * dot(bent.down, axis[1]), scale.z * dot(bent.down, axis[2])};
        row1 = mixed(bent.mix[0], p, bent.mix[1], q);
        row2 = mixed(bent.mix[2], p, bent.mix[3], q);
        finish();
    }
    /// V's rows become row1 + aside row2 and stretch row2.
    TILEMESH_KERNEL void shear(Real const& aside, Real const& stretch) noexcept
    {
        row1 = {A::multiply_add(aside, row2.x, row1.x), A::multiply_add(aside, row2.y, row1.y), A::multiply_add(aside, row2.z, row1.z)};
        row2 = {stretch * row2.x, stretch * row2.y, stretch * row2.z};
        finish();
    }

private:
    TILEMESH_KERNEL void finish() noexcept
    {
        a = dot(row1, row1);
        c = dot(row2, row2);
        b = dot(row1, row2);
        // |v1 x v2|^2, computed from the rounded rows. So an error of a row is in a, in c and in the determinant alike, and alpha depends on
        // their ratio. For a disc seen along its plane, a determinant with its own rounding has rho 56, this one 1.8.
        Vector3<A> const minor = cross(row1, row2);
        determinant = dot(minor, minor);
    }
    TILEMESH_KERNEL static Vector3<A> mixed(Real const& m, Vector3<A> const& p, Real const& n, Vector3<A> const& q) noexcept
    {
        return {A::multiply_add(m, p.x, n * q.x), A::multiply_add(m, p.y, n * q.y), A::multiply_add(m, p.z, n * q.z)};
    }
    TILEMESH_KERNEL static Real entry(Real const& px, Real const& scale, Real const& slope, Real const& depth,
                                      Real const& across) noexcept
    {
        return px * scale * A::multiply_add(-slope, depth, across);
    }
};
/// The largest absolute value among the entries of V; NaN is skipped.
inline float longest(Factor<OneFloat> const& f) noexcept
{
    float most = 0;
    for (float const v : {f.row1.x, f.row1.y, f.row1.z, f.row2.x, f.row2.y, f.row2.z})
        most = std::fabs(v) > most ? std::fabs(v) : most;
    return most;
}

/// v, clamped to [low, high]. NaN gives `low`.
template <class A>
TILEMESH_KERNEL typename A::Real clamp(typename A::Real const& v, typename A::Real const& low,
                                       typename A::Real const& high) noexcept
{
    auto const above = A::select(v > low, v, low);
    return A::select(above < high, above, high);
}
/// A slope of the Jacobian, clamped to [-limit, limit]. NaN stays NaN.
template <class A>
TILEMESH_KERNEL typename A::Real limited(typename A::Real const& slope, float limit) noexcept
{
    auto const most = A::all(limit), least = A::all(-limit);
    return A::select(slope < least, least, A::select(slope > most, most, slope));
}
/// The least integer that is not below v >= 0. NaN and infinity stay as they are.
template <class A>
TILEMESH_KERNEL typename A::Real round_up(typename A::Real const& v) noexcept
{
    auto const integers = A::all(8388608.0f); // from 2^23 on, every float is an integer
    auto const below = A::real(A::truncate(A::select(v < integers, v, integers)));
    return A::select(v < integers, below + A::select(below < v, A::all(1.0f), A::all(0.0f)), v);
}

/// The pixels [floor(centre - reach), floor(centre + reach)] that lie in [0, size), as x0 | x1 << 16; 0 if there are none. Values are
/// clamped as floats before they are converted, because a radius of 3e9 must not wrap.
template <class A>
TILEMESH_KERNEL typename A::Word pixel_span(typename A::Real const& centre, typename A::Real const& reach,
                                            std::uint32_t size) noexcept
{
    auto const zero = A::all(0.0f), limit = A::all(static_cast<float>(size));
    auto const low = centre - reach, high = centre + reach;
    auto const first = A::truncate(clamp<A>(low, zero, limit)), last = A::truncate(clamp<A>(high, zero, limit - 1.0f)) + 1;
    return A::keep(A::every(low < limit, high >= zero), first | last << 16); // 0 if either is NaN
}
/// The pixels of `span` that lie in the 16-pixel tiles of 3D Gaussian Splatting's rasteriser which [centre - radius, centre + radius]
/// touches; 0 if there are none. The rasteriser counts from the middle of the first pixel, and adds 15 before it rounds down, so a square
/// that reaches less than a pixel into a tile does not touch that tile. `size`: of the frame, in pixels.
template <class A>
TILEMESH_KERNEL typename A::Word span_in_tiles(typename A::Word const& span, typename A::Real const& centre,
                                               typename A::Real const& radius, std::uint32_t size) noexcept
{
    constexpr std::uint32_t tile = 16; // BLOCK_X and BLOCK_Y of the rasteriser
    auto const zero = A::all(0.0f), limit = A::all(static_cast<float>((size + tile - 1) / tile * tile));
    auto const middle = centre - 0.5f;
    auto const first = A::truncate(clamp<A>(middle - radius, zero, limit)) & -static_cast<std::int32_t>(tile);
    auto const last = A::truncate(clamp<A>(middle + radius + static_cast<float>(tile - 1), zero, limit)) & -static_cast<std::int32_t>(tile);
    auto const x0 = span & 0xffff, x1 = span >> 16 & 0xffff;
    auto const begin = x0 + A::keep(first > x0, first - x0), end = x1 - A::keep(last < x1, x1 - last);
    return A::keep(begin < end, begin | end << 16);
}
/// The pixel of `centre`, clamped into a span, as a float. It has no meaning if the span is empty.
template <class A>
TILEMESH_KERNEL typename A::Real pixel_clamped(typename A::Real const& centre, typename A::Word const& span) noexcept
{
    auto const first = A::real(span & 0xffff), last = A::real((span >> 16 & 0xffff) - 1);
    return A::real(A::truncate(clamp<A>(centre, first, last)));
}
/// pixel / size as an integer division, for a pixel below 2^16 and any size except 0. It is exact: the middle of a pixel is at least 0.5 /
/// size away from the next tile, and the two roundings together are below 2^16 / size * 2^-23.
template <class A>
TILEMESH_KERNEL typename A::Word tile_at(typename A::Real const& pixel, std::uint32_t size) noexcept
{
    return A::truncate((pixel + 0.5f) * (1.0f / static_cast<float>(size)));
}
/// The pixel of `centre`, clamped into a span that is not empty, as an integer.
inline std::uint32_t pixel_within(float centre, std::uint32_t span) noexcept
{
    return static_cast<std::uint32_t>(pixel_clamped<OneFloat>(centre, static_cast<std::int32_t>(span)));
}

/// The camera of the row on which a mean is seen (Shutter). A rotation is x + k (h x x + h x (h x x)) with h = tan(angle / 2) along its axis and k =
/// 2 / (1 + h^2): a rotation whatever h is, and within 8e-5 of its angle up to 1 radian.
template <class A>
struct RowMotion {
    using Real = typename A::Real;
    Vector3<A> h; ///< of the turn back
    Real k;
    Real v;       ///< of the row, in focal lengths
    typename A::Mask seen;

    /// `mean`: in the view space of row 0; it becomes that of its own row, by three rounds of a fixed point from row 0.
    TILEMESH_KERNEL RowMotion(Camera const& c, Vector3<A>& mean) noexcept
    {
        Shutter const& s = c.shutter;
        Vector3<A> const from = mean;
        v = A::all(0.0f);
        for (int round = 0;; ++round) {
            Real const theta2 = v * v * A::all(s.turn[0] * s.turn[0] + s.turn[1] * s.turn[1] + s.turn[2] * s.turn[2]);
            Real const series = A::multiply_add(theta2, A::multiply_add(theta2, A::multiply_add(theta2, A::all(17.0f / 20160), A::all(1.0f / 120)),
                                                                        A::all(1.0f / 12)), A::all(1.0f));
            Real const half = A::all(-0.5f) * v * series;
            h = {half * s.turn[0], half * s.turn[1], half * s.turn[2]};
            k = A::all(2.0f) / A::multiply_add(h.x, h.x, A::multiply_add(h.y, h.y, A::multiply_add(h.z, h.z, A::all(1.0f))));
            mean = turned({A::multiply_add(v, A::all(-s.move[0]), from.x), A::multiply_add(v, A::all(-s.move[1]), from.y),
                           A::multiply_add(v, A::all(-s.move[2]), from.z)});
            if (round == 3) break;
            Real row;
            if (c.lens.kind == LensKind::pinhole) {
                row = mean.y / mean.z;
                seen = mean.z > A::all(c.near_depth);
            } else {
                Bent<A> const bent(c, mean);
                row = bent.v, seen = bent.seen;
            }
            Real const most = A::all(s.reach), least = A::all(-s.reach);
            Real const above = A::select(row > least, row, least);
            v = A::select(seen, A::select(above < most, above, most), v);
        }
        if (c.lens.kind == LensKind::pinhole) seen = mean.z > A::all(c.near_depth); // a lens that bends says itself what it sees
    }
    TILEMESH_KERNEL Vector3<A> turned(Vector3<A> const& x) const noexcept
    {
        Vector3<A> const once = cross(h, x), twice = cross(h, once);
        return {A::multiply_add(k, once.x + twice.x, x.x), A::multiply_add(k, once.y + twice.y, x.y), A::multiply_add(k, once.z + twice.z, x.z)};
    }
    /// How fast a point of the row's view space moves there, a focal length of rows.
    TILEMESH_KERNEL Vector3<A> motion(Shutter const& s, Vector3<A> const& p) const noexcept
    {
        Vector3<A> const move = turned({A::all(s.move[0]), A::all(s.move[1]), A::all(s.move[2])});
        Vector3<A> const turn = cross(p, Vector3<A>{A::all(s.turn[0]), A::all(s.turn[1]), A::all(s.turn[2])});
        return {turn.x - move.x, turn.y - move.y, turn.z - move.z};
    }
};

/// What the rows' time does to V, where the picture of a mean moves by w = (across, down) pixels a focal length of rows: with w in pixels a row,
/// (1 - w e_y^T)^-1 V, so row1 + aside row2 and stretch row2. Not seen: the picture keeps up with the rows within an eighth.
template <class A>
struct RowShear {
    using Real = typename A::Real;
    Real aside, stretch;
    typename A::Mask seen;

    TILEMESH_KERNEL RowShear(Camera const& c, Real const& across, Real const& down) noexcept
    {
        Real const per_row = A::all(1.0f / c.fy), left = A::all(1.0f) - down * per_row;
        stretch = A::all(1.0f) / left;
        aside = across * per_row * stretch;
        seen = left > A::all(0.125f);
    }
};

/// The words of a Gaussian on which its projection depends.
template <class A>
struct GaussianWords {
    using Real = typename A::Real;
    Vector3<A> mean_world;
    Real colour[3], opacity, rotation[4];
    Vector3<A> log_scale;
};
/// The words of a Splat that the projection computes. The others are copied.
template <class A>
struct SplatWords {
    using Real = typename A::Real;
    Real mean_px[2], along, slope, across, opacity, faintest;
    typename A::Word depth_key, columns, rows, anchor;
};
/// `visible`: the lanes that show something. `stiff`: the lanes that need one of the rare branches of `project`. Vectors do not compute
/// these branches, so OneFloat must compute such a lane.
template <class A>
struct Outcome {
    typename A::Mask visible, stiff;
};

/// The words by which a projection's derivative by the camera's pose differs from the splat's own words (pose/motion.hpp). u3 says how far each
/// axis of the Gaussian reaches in depth: the third row of W R S, or through a fisheye its row along the ray. v1, v2 are the rows of V, and n =
/// v2 - slope v1.
template <class A>
struct PoseWords {
    static constexpr bool wanted = true;
    typename A::Real along_depth;  ///< v1 . u3 / a
    typename A::Real across_depth; ///< n . u3 / a
};
/// In their place, where nobody asks for a derivative. It costs nothing.
struct NoPoseWords {
    static constexpr bool wanted = false;
};

/// Nothing is visible in any lane. All words are defined.
template <class A>
TILEMESH_KERNEL Outcome<A> nowhere(SplatWords<A>& s) noexcept
{
    s = SplatWords<A>(); // GCC 12 does not accept {} for a class with vectors
    return Outcome<A>();
}

/// The work of `project`, for one Gaussian or for lanes of them. `s` has a meaning where it is visible and not stiff. Lanes select between
/// results; one float may return early instead, because nobody uses what it would have computed. `pose` has a meaning where `s` has one.
template <class A, class Optics = AnyLens, class Pose = NoPoseWords>
TILEMESH_KERNEL Outcome<A> project_words(GaussianWords<A> const& g, View const& view, TileSize const& tile,
                                         SplatWords<A>& s, [[maybe_unused]] Pose&& pose = {}) noexcept
{
    using Real = typename A::Real;
    Camera const& c = view.camera;
    Rules const& m = view.rules;
    typename A::Mask stiff{};
    bool const bends = Optics::bends && c.lens.kind != LensKind::pinhole, rolls = Optics::bends && c.shutter.reach > 0;

    // The mean in view space. Subtract first, so that large coordinates cancel before the rotation.
    Vector3<A> const d{g.mean_world.x - c.position[0], g.mean_world.y - c.position[1], g.mean_world.z - c.position[2]};
    Vector3<A> const w0{A::all(c.rotation[0][0]), A::all(c.rotation[0][1]), A::all(c.rotation[0][2])};
    Vector3<A> const w1{A::all(c.rotation[1][0]), A::all(c.rotation[1][1]), A::all(c.rotation[1][2])};
    Vector3<A> const w2{A::all(c.rotation[2][0]), A::all(c.rotation[2][1]), A::all(c.rotation[2][2])};
    Real z = dot(w2, d);
    constexpr float huge = 1e37f; // a larger value was not finite; an infinite depth would be NaN in pixels that take no part
    // A fisheye sees behind z = 0, and another row may see what this one does not; both say below what they see.
    Real const least_depth = A::all(rolls || (bends && c.lens.kind == LensKind::fisheye) ? -huge : c.near_depth);
    auto visible = A::every(z > least_depth, z < A::all(huge), g.opacity >= A::all(m.alpha_min));
    if (!A::any(visible)) return nowhere(s);
    for (Real const& channel : g.colour) visible = A::every(visible, A::magnitude(channel) <= A::all(largest_colour));
    Real const finite = A::all(std::numeric_limits<float>::max()); // -infinity is a size of zero
    visible = A::every(visible, g.log_scale.x <= finite, g.log_scale.y <= finite, g.log_scale.z <= finite);
    if constexpr (A::lanes == 1) {
        if (!visible) return nowhere(s);
    }
    Vector3<A> mean{dot(w0, d), dot(w1, d), z};
    Vector3<A> axis[3];
    typename A::Mask const odd = axes_of<A>(g.rotation, axis);
    if constexpr (A::lanes > 1) stiff = odd;
    Real const one = A::all(1.0f);
    Vector3<A> scale{A::exponential(g.log_scale.x), A::exponential(g.log_scale.y), A::exponential(g.log_scale.z)};

    // V and its covariance, and the mean in the picture, from the principal point.
    Factor<A> f;
    Real mean_x, mean_y;
    for (int i = 0; i < 3; ++i) f.axis[i] = {dot(w0, axis[i]), dot(w1, axis[i]), dot(w2, axis[i])};
    Vector3<A> moves = mean; // the mean, a focal length of rows
    if (rolls) {
        RowMotion<A> const row(c, mean);
        for (auto& each : f.axis) each = row.turned(each);
        moves = row.motion(c.shutter, mean);
        visible = A::every(visible, row.seen);
        if constexpr (A::lanes == 1) {
            if (!visible) return nowhere(s);
        }
        z = mean.z;
    }
    Real across = A::all(0.0f), down = across; // that motion in the picture
    if (bends) {
        Bent<A> const bent(c, mean);
        visible = A::every(visible, bent.seen);
        if constexpr (A::lanes == 1) {
            if (!visible) return nowhere(s);
        }
        f.multiply(scale, bent);
        if (rolls) {
            Real const p = dot(bent.across, moves), q = dot(bent.down, moves);
            across = A::multiply_add(bent.mix[0], p, bent.mix[1] * q), down = A::multiply_add(bent.mix[2], p, bent.mix[3] * q);
        }
        mean_x = c.fx * bent.u;
        mean_y = c.fy * bent.v;
    } else {
        Real const slope_x = mean.x / z, slope_y = mean.y / z;
        f.jx = limited<A>(slope_x, view.rules.slope_limit[0]);
        f.jy = limited<A>(slope_y, view.rules.slope_limit[1]);
        f.px_per_x = A::all(c.fx) / z;
        f.px_per_y = A::all(c.fy) / z;
        f.multiply(scale);
        if (rolls) {
            across = f.px_per_x * A::multiply_add(-f.jx, moves.z, moves.x), down = f.px_per_y * A::multiply_add(-f.jy, moves.z, moves.y);
        }
        mean_x = c.fx * slope_x;
        mean_y = c.fy * slope_y;
    }
    if (rolls) {
        RowShear<A> const shear(c, across, down);
        visible = A::every(visible, shear.seen);
        f.shear(shear.aside, shear.stretch);
    }

    // Above 1e9 pixels the determinant would leave the range of floats, so compute in units of a power of two of pixels. Axes are clamped
    // to 1e18 pixels; no real frame shows the difference. An infinite axis along the ray would be NaN across it.
    Real unit = one, per_unit = one;
    if constexpr (A::lanes > 1) {
        stiff = visible & (stiff | A::negation(f.a + f.c < A::all(1e18f)));
    } else if (!(f.a + f.c < 1e18f)) {
        auto const clamp_axes = [&](float px_per_unit) noexcept {
            float const most = 1e18f / px_per_unit;
            scale = {scale.x < most ? scale.x : most, scale.y < most ? scale.y : most, scale.z < most ? scale.z : most};
        };
        auto const take_unit = [&]() noexcept {
            unit = power_of_two_below(longest(f));
            per_unit = inverse_of_power(unit);
            scale = {scale.x * per_unit, scale.y * per_unit, scale.z * per_unit};
        };
        RowShear<A> const shear(c, across, down);
        float const more = rolls ? shear.stretch + std::fabs(shear.aside) : 1.0f;
        if (bends) {
            Bent<A> const bent(c, mean);
            clamp_axes(bent.steepest() * more);
            f.multiply(scale, bent);
            take_unit();
            f.multiply(scale, bent);
        } else {
            float const steepest = std::fabs(f.jx) > std::fabs(f.jy) ? std::fabs(f.jx) : std::fabs(f.jy);
            clamp_axes((f.px_per_x > f.px_per_y ? f.px_per_x : f.px_per_y) * (1.0f + steepest) * more);
            f.multiply(scale);
            take_unit();
            f.multiply(scale);
        }
        if (rolls) f.shear(shear.aside, shear.stretch);
    }
    Real const h = m.dilation * per_unit * per_unit;
    Real const a = f.a + h, cc = f.c + h, b = f.b;
    Real const determinant = f.determinant + A::multiply_add(h, f.a + f.c, h * h);
    visible = A::every(visible, a < A::all(huge), cc < A::all(huge), determinant > A::all(0.0f), determinant < A::all(huge));
    if constexpr (A::lanes == 1) {
        if (!visible) return nowhere(s);
    }

    Real opacity = A::select(g.opacity < one, g.opacity, one), shown = g.opacity;
    if (m.coverage == Coverage::preserved) {
        Real const kept = f.determinant / determinant, least = A::all(0.000025f);
        opacity = shown = opacity * A::square_root(A::select(kept > least, kept, least));
        visible = A::every(visible, opacity >= A::all(m.alpha_min));
        if constexpr (A::lanes == 1) {
            if (!visible) return nowhere(s);
        }
    }

    // The footprint, rounded outward to whole pixels.
    Real const ratio = 2.0f * logarithm<A>(shown / m.alpha_min);
    Real reach_x, reach_y;
    if (m.footprint != Footprint::three_sigma_square) {
        Real const t = A::square_root(ratio) * 1.00001f; // log and square root are rounded; the factor makes the box a superset
        reach_x = t * A::square_root(a) * unit;
        reach_y = t * A::square_root(cc) * unit;
    } else {
        Real const half = 0.5f * (a - cc);
        Real const largest = 0.5f * (a + cc) + A::square_root(A::multiply_add(half, half, b * b));
        reach_x = reach_y = round_up<A>(3.0f * A::square_root(largest) * unit);
    }
    Real const u = mean_x + c.cx, v = mean_y + c.cy;
    s.columns = pixel_span<A>(u, reach_x, c.width);
    s.rows = pixel_span<A>(v, reach_y, c.height);
    if (m.footprint == Footprint::three_sigma_tiles) {
        // The rasteriser's radius: the difference of the eigenvalues is at least 2 sqrt(0.1) pixels squared.
        Real const half = 0.5f * (a - cc), squared = A::multiply_add(half, half, b * b);
        Real const least = 0.1f * (per_unit * per_unit) * (per_unit * per_unit);
        Real const largest = 0.5f * (a + cc) + A::square_root(A::select(squared > least, squared, least));
        Real const radius = round_up<A>(3.0f * A::square_root(largest) * unit);
        s.columns = span_in_tiles<A>(s.columns, u, radius, c.width);
        s.rows = span_in_tiles<A>(s.rows, v, radius, c.height);
    }
    visible = A::every(visible, s.columns != 0, s.rows != 0);

    s.mean_px[0] = mean_x;
    s.mean_px[1] = mean_y;
    s.along = -0.5f / a * per_unit * per_unit;
    s.slope = b / a;
    s.across = -0.5f * a / determinant * per_unit * per_unit;
    s.opacity = opacity;
    s.depth_key = bends && c.lens.kind == LensKind::fisheye ? distance_keys<A>(mean)
                  : rolls                                   ? key_of<A>(z, A::all(0.0f))
                                                            : depth_keys<A>(c, g.mean_world, d);
    // If alpha_min is about e^-87 (the lower bound of `exponential`) or subnormal, no power is too faint.
    s.faintest = m.alpha_min > 1e-36f ? -0.5f * ratio - 0.01f : A::all(-std::numeric_limits<float>::infinity());
    auto const x = tile_at<A>(pixel_clamped<A>(u, s.columns), tile.tile_width);
    auto const y = tile_at<A>(pixel_clamped<A>(v, s.rows), tile.tile_height);
    s.anchor = x | y << 16;

    // n . u3 by two cross products: v2 . u3 - slope v1 . u3 would cancel for a needle.
    if constexpr (std::decay_t<Pose>::wanted) {
        Vector3<A> u3{f.axis[0].z * scale.x, f.axis[1].z * scale.y, f.axis[2].z * scale.z};
        if (bends && c.lens.kind == LensKind::fisheye) {
            Real const per_length = one / length<A>(mean);
            Vector3<A> const ray{mean.x * per_length, mean.y * per_length, mean.z * per_length};
            u3 = {dot(ray, f.axis[0]) * scale.x, dot(ray, f.axis[1]) * scale.y, dot(ray, f.axis[2]) * scale.z};
        }
        Real const per_a = one / a;
        pose.along_depth = dot(f.row1, u3) * per_a;
        pose.across_depth = A::multiply_add(h, dot(f.row2, u3), dot(cross(f.row1, f.row2), cross(f.row1, u3))) * per_a * per_a;
    }
    return {visible, stiff};
}
} // namespace detail

/// Projects a Gaussian by EWA splatting (Zwicker et al. 2001), as 3DGS does. It uses a factored form, which stays accurate for needles: the
/// covariance is V V^T with V = J W R S (2 x 3), and its determinant is the squared length of the cross product of V's rows.
///
/// A Gaussian that cannot be drawn gives an invisible splat, not an error: it is behind the near plane, its opacity is under alpha_min, it
/// is outside the screen, or its projection is not finite. The size of a tile sets `Splat::anchor` alone. Cost: about 150 flops, three square roots,
/// nine divisions, four exponentials or logarithms.
template <class Optics = AnyLens>
Splat project(Gaussian const& g, View const& view, TileSize const& tile) noexcept
{
    using detail::OneFloat;
    detail::GaussianWords<OneFloat> const words{{g.mean_world[0], g.mean_world[1], g.mean_world[2]},
                                                {g.colour[0], g.colour[1], g.colour[2]},
                                                g.opacity,
                                                {g.rotation[0], g.rotation[1], g.rotation[2], g.rotation[3]},
                                                {g.log_scale[0], g.log_scale[1], g.log_scale[2]}};
    detail::SplatWords<OneFloat> s;
    if (!detail::project_words<OneFloat, Optics>(words, view, tile, s).visible) return {};
    return {{s.mean_px[0], s.mean_px[1]},
            s.along,
            s.slope,
            s.across,
            s.opacity,
            {g.colour[0], g.colour[1], g.colour[2]},
            static_cast<std::uint32_t>(s.depth_key),
            s.faintest,
            static_cast<std::uint32_t>(s.columns),
            static_cast<std::uint32_t>(s.rows),
            {static_cast<std::uint32_t>(s.anchor)}};
}

/// The depth key of a Gaussian, as in its projection; 0 if the depth is not greater than the near plane's or not finite.
inline std::uint32_t depth_key(Gaussian const& g, View const& view) noexcept
{
    using namespace detail;
    Camera const& c = view.camera;
    Float3 const d{g.mean_world[0] - c.position[0], g.mean_world[1] - c.position[1], g.mean_world[2] - c.position[2]};
    float const z = dot<OneFloat>({c.rotation[2][0], c.rotation[2][1], c.rotation[2][2]}, d);
    bool const rolls = c.shutter.reach > 0;
    if (rolls || sees_behind(c.lens.kind)) {
        Float3 p{dot<OneFloat>({c.rotation[0][0], c.rotation[0][1], c.rotation[0][2]}, d),
                 dot<OneFloat>({c.rotation[1][0], c.rotation[1][1], c.rotation[1][2]}, d), z};
        if (rolls) (void)RowMotion<OneFloat>(c, p);
        if (!sees_behind(c.lens.kind)) return p.z > c.near_depth && p.z < 1e37f ? key_of_depth(p.z) : 0;
        float const distance = length<OneFloat>(p);
        return distance > c.near_depth && distance <= std::numeric_limits<float>::max() ? static_cast<std::uint32_t>(distance_keys<OneFloat>(p)) : 0;
    }
    if (!(z > c.near_depth && z <= std::numeric_limits<float>::max())) return 0;
    return static_cast<std::uint32_t>(depth_keys<OneFloat>(c, {g.mean_world[0], g.mean_world[1], g.mean_world[2]}, d));
}

/// The share of a splat's light that a pixel centre gets if nothing is in front of it: opacity e^power, in [0, 1]. `x` and `y` are relative
/// to the principal point. Kernels and the naive picture share this function. `lowest`: the power that stands for all lower ones.
inline float alpha_at(Splat const& s, float x, float y, float lowest = detail::lowest_power) noexcept
{
    float const dx = x - s.mean_px[0], dy = y - s.mean_px[1];
    float const off = multiply_add(-s.slope, dx, dy);
    float const power = multiply_add(s.along * dx, dx, s.across * off * off);
    return s.opacity * exponential(power, lowest);
}

}}} // namespace tilemesh::splat
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
