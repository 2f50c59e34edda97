#pragma once
#include <tilemesh/splat/harmonics.hpp>
#include <tilemesh/splat/map/sums.hpp>

/// The chain rule from a splat's sums to its Gaussian's parameters, once a splat and view, at the anchor.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // the functions are always inlined, so it does not matter how a wide vector is passed
namespace tilemesh { inline namespace v0_2 { namespace splat::map {

/// The parameters of a Gaussian, and their places among the slopes. The opacity is moved by its logit.
enum class Kind : std::uint32_t { mean, log_scale, rotation, logit, colour };
inline constexpr std::uint32_t kinds = 5, parameters = 14;
struct Places {
    std::uint32_t first, end;
};
constexpr Places places_of(Kind kind) noexcept
{
    constexpr std::uint32_t at[kinds + 1] = {0, 3, 6, 10, 11, 14};
    return {at[static_cast<std::uint32_t>(kind)], at[static_cast<std::uint32_t>(kind) + 1]};
}

/// The slopes of a loss by the parameters of a Gaussian: mean (3), log-scale (3), quaternion w x y z (4), logit, colour (3).
template <class A>
struct Slopes {
    typename A::Real of[parameters];
};

namespace detail {
template <class A>
TILEMESH_KERNEL splat::detail::Vector3<A> combined(typename A::Real const& a, splat::detail::Vector3<A> const& u, typename A::Real const& b,
                                                   splat::detail::Vector3<A> const& v) noexcept
{
    return {A::multiply_add(a, u.x, b * v.x), A::multiply_add(a, u.y, b * v.y), A::multiply_add(a, u.z, b * v.z)};
}
/// The slope by the mean in view space.
template <class A>
struct ViewSlope {
    typename A::Real x, y, z;
};
} // namespace detail

/// The chain rule. It returns where the slopes have a meaning; elsewhere they are 0, and the Gaussian gets no step: its quaternion's
/// square is not between 1e-30 and 1e30, an axis is longer than 1e9 pixels, or a slope is not finite or beyond 1e30.
///
/// With the hats r1 = v1 sqrt(-2 along) and r2 = (v2 - slope v1) sqrt(-2 across) of the rows of V = J W R S, the slope by row 2 is dv2 =
/// (M11 r1 + M02 r2) sqrt(-2 across), by row 1 dv1 = (M20 r1 + M11 r2) sqrt(-2 along) - slope dv2, and by log-scale i M20 r1_i^2 + 2 M11
/// r1_i r2_i + M02 r2_i^2. v2 - slope v1 comes from a double cross product, so nothing cancels for a needle.
///
/// With `Coverage::preserved`, the opacity's share is sqrt(|C| / |C + h|) for C = V V^T. The slope by V grows by gP (C^-1 - (C + h)^-1) V, the
/// derivative of the share's logarithm; where the share is at its bound of 0.005, it grows by nothing.
///
/// The colour's slope is there also where a colour is 0: the optimiser clamps after its step, or a black splat would stay black. Requires
/// the sums of this Gaussian in this view. The sets of pairs are constant. Cost: about 200 multiply-adds, five
/// divisions, three roots.
///
/// Through a lens of slopes, J moves with the mean by the second derivatives of the lens, up to its limit. Beyond it, neither J nor the slope
/// by which the mean moves in the picture turns with the mean: an approximation, outside the picture.
template <class A, class Optics = AnyLens>
TILEMESH_KERNEL typename A::Mask chain_rule(splat::detail::GaussianWords<A> const& g, View const& view, Moments<A> const& m,
                                            Slopes<A>& out) noexcept
{
    using Real = typename A::Real;
    using Vector = splat::detail::Vector3<A>;
    using splat::detail::dot;
    Camera const& c = view.camera;
    Real const one = A::all(1.0f), two = A::all(2.0f), zero = A::all(0.0f);

    // The view, as in the projection.
    Vector const d{g.mean_world.x - c.position[0], g.mean_world.y - c.position[1], g.mean_world.z - c.position[2]};
    Vector const w0{A::all(c.rotation[0][0]), A::all(c.rotation[0][1]), A::all(c.rotation[0][2])};
    Vector const w1{A::all(c.rotation[1][0]), A::all(c.rotation[1][1]), A::all(c.rotation[1][2])};
    Vector const w2{A::all(c.rotation[2][0]), A::all(c.rotation[2][1]), A::all(c.rotation[2][2])};
    Real const z = dot(w2, d), per_z = one / z, sx = dot(w0, d) / z, sy = dot(w1, d) / z;
    Real const qw = g.rotation[0], qx = g.rotation[1], qy = g.rotation[2], qz = g.rotation[3];
    Real const norm = splat::detail::squared_length<A>(qw, qx, qy, qz), per_norm = one / norm, t = two / norm;
    Real const xx = t * qx * qx, yy = t * qy * qy, zz = t * qz * qz, xy = t * qx * qy, xz = t * qx * qz, yz = t * qy * qz;
    Real const wx = t * qw * qx, wy = t * qw * qy, wz = t * qw * qz;
    Vector const axis[3] = {{one - (yy + zz), xy + wz, xz - wy}, {xy - wz, one - (xx + zz), yz + wx}, {xz + wy, yz - wx, one - (xx + yy)}};
    Vector const scale{A::exponential(g.log_scale.x), A::exponential(g.log_scale.y), A::exponential(g.log_scale.z)};
    splat::detail::Factor<A> f;
    bool const bends = Optics::bends && c.lens.kind != LensKind::pinhole;
    f.jx = splat::detail::limited<A>(sx, view.rules.slope_limit[0]);
    f.jy = splat::detail::limited<A>(sy, view.rules.slope_limit[1]);
    f.px_per_x = A::all(c.fx) / z;
    f.px_per_y = A::all(c.fy) / z;
    for (int i = 0; i < 3; ++i) f.axis[i] = {dot(w0, axis[i]), dot(w1, axis[i]), dot(w2, axis[i])};
    Vector const mean{dot(w0, d), dot(w1, d), z};
    splat::detail::Bent<A> const bent = bends ? splat::detail::Bent<A>(c, mean) : splat::detail::Bent<A>();
    if (bends) f.multiply(scale, bent);
    else f.multiply(scale);
    Real const free_x = A::select(A::magnitude(sx) <= A::all(view.rules.slope_limit[0]), one, zero);
    Real const free_y = A::select(A::magnitude(sy) <= A::all(view.rules.slope_limit[1]), one, zero);

    // The hats.
    Real const h = A::all(view.rules.dilation), a = f.a + h, per_a = one / a, k = f.b * per_a;
    Real const across = (f.determinant + A::multiply_add(h, f.a + f.c, h * h)) * per_a;
    Real const ra = one / A::square_root(a), rs = one / A::square_root(across);
    Vector const minor = splat::detail::cross(f.row1, splat::detail::cross(f.row2, f.row1)); // a v2 - b v1, without the dilation
    Vector const off = detail::combined<A>(per_a, minor, h * per_a, f.row2);
    Vector const r1{ra * f.row1.x, ra * f.row1.y, ra * f.row1.z}, r2{rs * off.x, rs * off.y, rs * off.z};
    Vector const s1 = detail::combined<A>(m.of[gp_xx], r1, m.of[gp_xo], r2), s2 = detail::combined<A>(m.of[gp_xo], r1, m.of[gp_oo], r2);
    Vector dv2{rs * s2.x, rs * s2.y, rs * s2.z};
    Vector dv1{A::multiply_add(-k, dv2.x, ra * s1.x), A::multiply_add(-k, dv2.y, ra * s1.y), A::multiply_add(-k, dv2.z, ra * s1.z)};
    Real const by_v = rs * m.of[gp_o], by_u = A::multiply_add(-k, by_v, ra * m.of[gp_x]); // the mean on the screen

    // Log-scales: s1 . r1 + s2 . r2, axis by axis.
    Real* const log_scale = out.of + places_of(Kind::log_scale).first;
    log_scale[0] = A::multiply_add(s1.x, r1.x, s2.x * r2.x);
    log_scale[1] = A::multiply_add(s1.y, r1.y, s2.y * r2.y);
    log_scale[2] = A::multiply_add(s1.z, r1.z, s2.z * r2.z);

    // The share of the opacity that preserved coverage leaves: the derivative of its logarithm, where the bound does not hold it.
    if (view.rules.coverage == Coverage::preserved) {
        Real const dilated = across * a, kept = f.determinant / dilated;
        auto const above = kept > A::all(0.000025f);
        Real const by = A::select(above, m.of[gp], zero) / dilated, of_own = by / A::select(above, kept, one) - by;
        Vector const other = splat::detail::cross(f.row2, splat::detail::cross(f.row1, f.row2)); // c v1 - b v2, without the dilation
        Vector const more1 = detail::combined<A>(of_own, other, -h * by, f.row1), more2 = detail::combined<A>(of_own, minor, -h * by, f.row2);
        dv1 = {dv1.x + more1.x, dv1.y + more1.y, dv1.z + more1.z};
        dv2 = {dv2.x + more2.x, dv2.y + more2.y, dv2.z + more2.z};
        log_scale[0] = log_scale[0] + A::multiply_add(more1.x, f.row1.x, more2.x * f.row2.x);
        log_scale[1] = log_scale[1] + A::multiply_add(more1.y, f.row1.y, more2.y * f.row2.y);
        log_scale[2] = log_scale[2] + A::multiply_add(more1.z, f.row1.z, more2.z * f.row2.z);
    }

    // Slopes by the axes W R of the Gaussian, in view space, and by the mean: through the screen, through J, and its own depth.
    Real const sizes = log_scale[0] + (log_scale[1] + log_scale[2]);
    Real along_x[3], along_y[3], along_z[3];
    detail::ViewSlope<A> p;
    if (bends) {
        Vector const e1{dv1.x * scale.x, dv1.y * scale.y, dv1.z * scale.z}, e2{dv2.x * scale.x, dv2.y * scale.y, dv2.z * scale.z};
        Vector const j1 = detail::combined<A>(bent.mix[0], bent.across, bent.mix[1], bent.down);
        Vector const j2 = detail::combined<A>(bent.mix[2], bent.across, bent.mix[3], bent.down);
        Real const of1[3] = {e1.x, e1.y, e1.z}, of2[3] = {e2.x, e2.y, e2.z};
        Vector by1{zero, zero, zero}, by2 = by1; // slopes by the rows of J
        for (std::uint32_t i = 0; i < 3; ++i) {
            along_x[i] = A::multiply_add(of1[i], j1.x, of2[i] * j2.x);
            along_y[i] = A::multiply_add(of1[i], j1.y, of2[i] * j2.y);
            along_z[i] = A::multiply_add(of1[i], j1.z, of2[i] * j2.z);
            by1 = {A::multiply_add(of1[i], f.axis[i].x, by1.x), A::multiply_add(of1[i], f.axis[i].y, by1.y),
                   A::multiply_add(of1[i], f.axis[i].z, by1.z)};
            by2 = {A::multiply_add(of2[i], f.axis[i].x, by2.x), A::multiply_add(of2[i], f.axis[i].y, by2.y),
                   A::multiply_add(of2[i], f.axis[i].z, by2.z)};
        }
        if (c.lens.kind == LensKind::fisheye) {
            splat::detail::FisheyeCurvature<A> const bend(c.lens, mean);
            Real const fx = A::all(c.fx), fy = A::all(c.fy), g1 = fx * dot(bend.slope, by1), g2 = fy * dot(bend.slope, by2);
            Vector const h1 = bend.times(by1), h2 = bend.times(by2);
            Real const own = A::multiply_add(fx, by1.x, fy * by2.y), to1 = fx * mean.x, to2 = fy * mean.y, per_depth = m.of[w_depth] / bent.depth;
            auto const by = [&](Real const& j1_i, Real const& j2_i, Real const& slope, Real const& h1_i, Real const& h2_i, Real const& mean_i,
                                Real& to) noexcept {
                to = A::multiply_add(by_u, j1_i, by_v * j2_i) + A::multiply_add(own, slope, A::multiply_add(to1, h1_i, to2 * h2_i)) +
                     per_depth * mean_i;
            };
            by(j1.x, j2.x, bend.slope.x, h1.x, h2.x, mean.x, p.x);
            by(j1.y, j2.y, bend.slope.y, h1.y, h2.y, mean.y, p.y);
            by(j1.z, j2.z, bend.slope.z, h1.z, h2.z, mean.z, p.z);
            p.x = p.x + g1, p.y = p.y + g2;
        } else {
            splat::detail::LensCurvature<A> const bend(c.lens, bent.x, bent.y);
            Real const q1x = by1.x - bent.x * by1.z, q1y = by1.y - bent.y * by1.z, q2x = by2.x - bent.x * by2.z, q2y = by2.y - bent.y * by2.z;
            Real const fx = f.px_per_x * per_z, fy = f.px_per_y * per_z;
            Real const inside = A::select(A::every(bent.x == sx, bent.y == sy), one, zero);
            Real const tx = fx * A::multiply_add(bend.u_xx, q1x, bend.u_xy * q1y) + fy * A::multiply_add(bend.u_xy, q2x, bend.u_yy * q2y);
            Real const ty = fx * A::multiply_add(bend.u_xy, q1x, bend.u_yy * q1y) + fy * A::multiply_add(bend.u_yy, q2x, bend.v_yy * q2y);
            Real const g1 = by1.z * per_z, g2 = by2.z * per_z;
            Real const from_x = A::multiply_add(by_u, bent.mix[0], by_v * bent.mix[2]);
            Real const from_y = A::multiply_add(by_u, bent.mix[1], by_v * bent.mix[3]);
            p = {from_x + inside * (tx - A::multiply_add(g1, j1.x, g2 * j2.x)), from_y + inside * (ty - A::multiply_add(g1, j1.y, g2 * j2.y)),
                 m.of[w_depth] - A::multiply_add(from_x, sx, from_y * sy) - sizes * per_z -
                     inside * (A::multiply_add(g1, j1.z, g2 * j2.z) + A::multiply_add(bent.x, tx, bent.y * ty))};
        }
    } else {
        Vector const e1{dv1.x * f.px_per_x * scale.x, dv1.y * f.px_per_x * scale.y, dv1.z * f.px_per_x * scale.z};
        Vector const e2{dv2.x * f.px_per_y * scale.x, dv2.y * f.px_per_y * scale.y, dv2.z * f.px_per_y * scale.z};
        Vector const depths{f.axis[0].z, f.axis[1].z, f.axis[2].z};
        Real const by_jx = -dot(e1, depths) * free_x, by_jy = -dot(e2, depths) * free_y;
        Real const from_u = by_u * f.px_per_x, from_v = by_v * f.px_per_y;
        p = {A::multiply_add(by_jx, per_z, from_u), A::multiply_add(by_jy, per_z, from_v),
             m.of[w_depth] - A::multiply_add(from_u, sx, from_v * sy) - (sizes + A::multiply_add(by_jx, f.jx, by_jy * f.jy)) * per_z};
        Real const across_x[3] = {e1.x, e1.y, e1.z}, across_y[3] = {e2.x, e2.y, e2.z};
        for (std::uint32_t i = 0; i < 3; ++i)
            along_x[i] = across_x[i], along_y[i] = across_y[i], along_z[i] = -A::multiply_add(f.jx, across_x[i], f.jy * across_y[i]);
    }
    for (std::uint32_t i = 0; i < 3; ++i)
        out.of[i] = A::multiply_add(A::all(c.rotation[0][i]), p.x, A::multiply_add(A::all(c.rotation[1][i]), p.y,
            A::all(c.rotation[2][i]) * p.z));

    // The quaternion: slopes by R in world space, then by R(q / |q|); the part along q is 0.
    Real turn[3][3]; // [row][axis]
    for (std::uint32_t j = 0; j < 3; ++j) {
        for (std::uint32_t i = 0; i < 3; ++i)
            turn[i][j] = A::multiply_add(A::all(c.rotation[0][i]), along_x[j],
                                         A::multiply_add(A::all(c.rotation[1][i]), along_y[j], A::all(c.rotation[2][i]) * along_z[j]));
    }
    Real const turn_x = turn[2][1] - turn[1][2], turn_y = turn[0][2] - turn[2][0], turn_z = turn[1][0] - turn[0][1];
    Real const sxy = turn[0][1] + turn[1][0], sxz = turn[0][2] + turn[2][0], syz = turn[1][2] + turn[2][1];
    Real q[4] = {two * (qx * turn_x + qy * turn_y + qz * turn_z),
                 two * (qw * turn_x + qy * sxy + qz * sxz - two * qx * (turn[1][1] + turn[2][2])),
                 two * (qw * turn_y + qx * sxy + qz * syz - two * qy * (turn[0][0] + turn[2][2])),
                 two * (qw * turn_z + qx * sxz + qy * syz - two * qz * (turn[0][0] + turn[1][1]))};
    Real const along = (q[0] * qw + q[1] * qx + q[2] * qy + q[3] * qz) * per_norm;
    Real const own[4] = {qw, qx, qy, qz};
    for (std::uint32_t i = 0; i < 4; ++i) out.of[places_of(Kind::rotation).first + i] = (q[i] - along * own[i]) * per_norm;

    // Opacity and colour.
    out.of[places_of(Kind::logit).first] = m.of[gp] * (one - A::select(g.opacity < one, g.opacity, one));
    for (std::uint32_t i = 0; i < 3; ++i) out.of[places_of(Kind::colour).first + i] = m.of[w_red + i];

    Real const most = A::all(1e30f);
    auto sound = A::every(norm > A::all(1e-30f), norm < most, f.a + f.c < A::all(1e18f));
    for (Real const& v : out.of) sound = A::every(sound, A::magnitude(v) < most); // false for NaN
    for (Real& v : out.of) v = A::select(sound, v, zero);
    return sound;
}

/// The slopes of one record.
using RecordSlopes = Slopes<splat::detail::OneFloat>;

/// `chain_rule` for a record.
template <class Optics = AnyLens>
bool slopes_of(Gaussian const& g, View const& view, Moments<splat::detail::OneFloat> const& m, RecordSlopes& out) noexcept
{
    splat::detail::GaussianWords<splat::detail::OneFloat> const words{{g.mean_world[0], g.mean_world[1], g.mean_world[2]},
                                                                      {g.colour[0], g.colour[1], g.colour[2]},
                                                                      g.opacity,
                                                                      {g.rotation[0], g.rotation[1], g.rotation[2], g.rotation[3]},
                                                                      {g.log_scale[0], g.log_scale[1], g.log_scale[2]}};
    return chain_rule<splat::detail::OneFloat, Optics>(words, view, m, out);
}

}}} // namespace tilemesh::splat::map
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
