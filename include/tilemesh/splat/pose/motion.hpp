#pragma once
#include <tilemesh/splat/projection.hpp>
#include <tilemesh/splat/view.hpp>

TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // the functions are always inlined, so it does not matter how a wide vector is passed
namespace tilemesh { inline namespace v0_2 { namespace splat::pose {

/// The six motions by which a frame is differentiated. A point p of view space moves by dp = rho + phi x p: rho is a translation in world
/// units, phi a rotation in radians about the camera centre.
inline constexpr std::uint32_t motions = 6;
enum class Column : std::uint32_t { rho_x, rho_y, rho_z, phi_x, phi_y, phi_z };

/// The two words that a splat needs for its derivative, besides its own. v1, v2 are the rows of V = J W R S, u3 is the third row of W R S (its
/// row along the ray through a fisheye), a the first entry of the dilated covariance, and n = v2 - slope v1. Only programs that track carry them.
struct Terms {
    float along_depth;  ///< v1 . u3 / a, world units per pixel
    float across_depth; ///< n . u3 / a
};
/// A splat of a program that tracks: 64 bytes.
struct PoseSplat : Splat {
    Terms terms;
    PoseSplat() noexcept = default;
    explicit PoseSplat(Splat const& s, Terms const& t = {}) noexcept : Splat(s), terms(t) {}
};
static_assert(sizeof(PoseSplat) == 64 && std::is_trivially_copyable_v<PoseSplat>, "a splat that tracks is 16 words");

/// The two words of a Gaussian that is visible; 0 for others.
inline Terms terms_of(Gaussian const& g, View const& view, TileSize const& tile) noexcept
{
    using splat::detail::OneFloat;
    splat::detail::GaussianWords<OneFloat> const words{{g.mean_world[0], g.mean_world[1], g.mean_world[2]},
                                                       {g.colour[0], g.colour[1], g.colour[2]},
                                                       g.opacity,
                                                       {g.rotation[0], g.rotation[1], g.rotation[2], g.rotation[3]},
                                                       {g.log_scale[0], g.log_scale[1], g.log_scale[2]}};
    splat::detail::SplatWords<OneFloat> same;
    splat::detail::PoseWords<OneFloat> pose{};
    if (!splat::detail::project_words<OneFloat, AnyLens>(words, view, tile, same, pose).visible) return {};
    return {pose.along_depth, pose.across_depth};
}
/// `project`, with the two words of the derivative.
inline PoseSplat project(Gaussian const& g, View const& view, TileSize const& tile) noexcept
{
    return PoseSplat(splat::project(g, view, tile), terms_of(g, view, tile));
}

/// The derivative of a splat's power by one motion. With dx, dy from the mean to a pixel and off = dy - slope dx:
/// dP = dx dx_1 + off off_1 + dx^2 dx_2 + dx off mixed + off^2 off_2.
template <class A>
struct PowerMotion {
    typename A::Real dx_1, off_1, dx_2, mixed, off_2;
};

/// The words of a splat on which its motion depends.
template <class A>
struct MovingSplat {
    typename A::Real mean_x, mean_y, depth, along, slope, across, along_depth, across_depth;
};

namespace detail {
template <class A>
using Vector3 = splat::detail::Vector3<A>;
/// The unit vector that a motion moves or turns along.
template <Column J, class A>
TILEMESH_KERNEL Vector3<A> axis_of() noexcept
{
    auto const one = A::all(1.0f), zero = A::all(0.0f);
    if constexpr (J == Column::rho_x || J == Column::phi_x) return {one, zero, zero};
    else if constexpr (J == Column::rho_y || J == Column::phi_y) return {zero, one, zero};
    else return {zero, zero, one};
}
/// A point of view space through a fisheye: its ray, and the Jacobian in pixels.
template <class A>
struct FisheyePoint {
    using Real = typename A::Real;
    Vector3<A> ray, p, row[2];
    splat::detail::FisheyeCurvature<A> curvature;

    FisheyePoint() noexcept = default;
    /// u, v: its place in the picture, in focal lengths from the principal point. fx, fy: pixels.
    TILEMESH_KERNEL FisheyePoint(Camera const& camera, Real const& u, Real const& v, Real const& distance, float fx, float fy) noexcept
        : ray(splat::detail::LensRay<A>(camera, u, v).ray), p{ray.x * distance, ray.y * distance, ray.z * distance}, curvature(camera.lens, p)
    {
        row[0] = curvature.row(0, fx), row[1] = curvature.row(1, fy);
    }
    /// How motion J moves the point.
    template <Column J>
    TILEMESH_KERNEL Vector3<A> moved() const noexcept
    {
        if constexpr (J < Column::phi_x) return axis_of<J, A>();
        else return splat::detail::cross<A>(axis_of<J, A>(), p);
    }
};

/// What all columns share.
template <class A>
struct MotionBasis {
    using Real = typename A::Real;
    Real along, across, k;
    Real along_depth, across_depth;
    Real per_z, sx, sy;       ///< 1 / depth, slopes of the mean
    Real jx, jy;              ///< slopes of the Jacobian: clamped
    Real free_x, free_y;      ///< 1; 0 where that slope is clamped, so that the Jacobian does not move with the mean
    Real px, py;              ///< pixels per world unit
    Real fx, fy, ratio, per_ratio;
    Real h_a, nn_a, a_s;      ///< dilation / a, n . n / a, a / (the variance across)
    bool by_angle = false;    ///< through a fisheye; then:
    FisheyePoint<A> mean;
    Real inverse[3];          ///< of the 2 x 2 matrix J J^T
    bool bends = false;       ///< through a lens of slopes; then:
    Real d00, d01, d11;       ///< its derivatives
    Real per_determinant;     ///< of these
    Real u_xx, u_xy, u_yy, v_yy;

    TILEMESH_KERNEL MotionBasis(MovingSplat<A> const& s, View const& view) noexcept
    {
        Real const one = A::all(1.0f), zero = A::all(0.0f);
        along = s.along, across = s.across, k = s.slope;
        along_depth = s.along_depth, across_depth = s.across_depth;
        fx = A::all(view.camera.fx), fy = A::all(view.camera.fy);
        ratio = fx / fy, per_ratio = fy / fx;
        per_z = one / s.depth;
        sx = s.mean_x / fx, sy = s.mean_y / fy;
        if (view.camera.lens.kind == LensKind::fisheye) {
            turn(view.camera, s.depth);
        } else if (view.camera.lens.kind != LensKind::pinhole) {
            bend(view.camera.lens);
        } else {
            jx = splat::detail::limited<A>(sx, view.rules.slope_limit[0]);
            jy = splat::detail::limited<A>(sy, view.rules.slope_limit[1]);
            free_x = A::select(A::magnitude(sx) <= A::all(view.rules.slope_limit[0]), one, zero);
            free_y = A::select(A::magnitude(sy) <= A::all(view.rules.slope_limit[1]), one, zero);
        }
        px = fx * per_z, py = fy * per_z;
        h_a = A::all(-2.0f * view.rules.dilation) * along;
        a_s = across / along;
        nn_a = along / across - h_a * A::multiply_add(k, k, one);
    }

private:
    TILEMESH_KERNEL void turn(Camera const& camera, Real const& distance) noexcept
    {
        by_angle = true;
        mean = FisheyePoint<A>(camera, sx, sy, distance, camera.fx, camera.fy);
        Real const g11 = splat::detail::dot(mean.row[0], mean.row[0]), g12 = splat::detail::dot(mean.row[0], mean.row[1]);
        Real const g22 = splat::detail::dot(mean.row[1], mean.row[1]), per = A::all(1.0f) / A::multiply_add(g11, g22, -(g12 * g12));
        inverse[0] = g22 * per, inverse[1] = -(g12 * per), inverse[2] = g11 * per;
        jx = jy = free_x = free_y = A::all(0.0f);
    }
    /// A lens knows the mean's place, and not its slopes. They are found again, and the Jacobian moves up to the limit of the lens.
    TILEMESH_KERNEL void bend(Lens const& lens) noexcept
    {
        Real const u = sx, v = sy;
        splat::detail::unbend<A>(lens, u, v, sx, sy);
        splat::detail::BentSlopes<A> const at(lens, sx, sy);
        splat::detail::LensCurvature<A> const curvature(lens, at.x, at.y);
        bends = true;
        jx = at.x, jy = at.y;
        free_x = free_y = A::select(at.within, A::all(1.0f), A::all(0.0f));
        d00 = at.d00, d01 = at.d01, d11 = at.d11;
        per_determinant = A::all(1.0f) / A::multiply_add(d00, d11, -(d01 * d01));
        u_xx = curvature.u_xx, u_xy = curvature.u_xy, u_yy = curvature.u_yy, v_yy = curvature.v_yy;
    }
};
/// How one motion moves the mean's slopes (through a lens: its place over the focal lengths), and the rows of V:
/// dv1 = p1 v1 + q1 v2 + kx u3 and dv2 = q2 v1 + (p1 + dp) v2 + ky u3.
template <class A>
struct RowMotion {
    typename A::Real dsx, dsy, kx, ky, p1, dp, q1, q2;
};
/// Through a fisheye J p = 0, so dV = B V + gamma u with the row u along the ray: B = (dJ + J [phi]x) J^+, gamma = -J rho / |p|.
template <Column J, class A>
TILEMESH_KERNEL RowMotion<A> row_motion_by_angle(MotionBasis<A> const& b) noexcept
{
    using Real = typename A::Real;
    using splat::detail::dot;
    auto const& at = b.mean;
    Vector3<A> const moved = at.template moved<J>(), bent = at.curvature.times(moved), axis = axis_of<J, A>();
    Real const slope = dot(at.curvature.slope, moved), focal[2] = {b.fx, b.fy};
    Real place[2], along[2], n[2][2];
    for (int k = 0; k < 2; ++k) {
        Vector3<A> const& row = at.row[k];
        Real const own = k == 0 ? at.p.x : at.p.y, step = k == 0 ? moved.x : moved.y;
        Vector3<A> change{A::multiply_add(step, at.curvature.slope.x, own * bent.x), A::multiply_add(step, at.curvature.slope.y, own * bent.y),
                          A::multiply_add(step, at.curvature.slope.z, own * bent.z)};
        (k == 0 ? change.x : change.y) = (k == 0 ? change.x : change.y) + slope;
        change = {focal[k] * change.x, focal[k] * change.y, focal[k] * change.z};
        place[k] = dot(row, moved), along[k] = A::all(0.0f);
        if constexpr (J < Column::phi_x) {
            along[k] = -(dot(row, axis) * b.per_z);
        } else {
            Vector3<A> const turned = splat::detail::cross<A>(row, axis);
            change = {change.x + turned.x, change.y + turned.y, change.z + turned.z};
        }
        Real const first = dot(change, at.row[0]), second = dot(change, at.row[1]);
        n[k][0] = A::multiply_add(first, b.inverse[0], second * b.inverse[1]), n[k][1] = A::multiply_add(first, b.inverse[1], second * b.inverse[2]);
    }
    return {place[0] / b.fx, place[1] / b.fy, along[0], along[1], n[0][0], n[1][1] - n[0][0], n[0][1], n[1][0]};
}
template <Column J, class A>
TILEMESH_KERNEL RowMotion<A> row_motion(MotionBasis<A> const& b) noexcept
{
    using Real = typename A::Real;
    if (b.by_angle) return row_motion_by_angle<J>(b);
    Real const zero = A::all(0.0f), one = A::all(1.0f);
    RowMotion<A> m{zero, zero, zero, zero, zero, zero, zero, zero};
    Real kx = zero, ky = zero; // the rotation's part of kx, ky
    if constexpr (J == Column::rho_x) {
        m.dsx = b.per_z;
    } else if constexpr (J == Column::rho_y) {
        m.dsy = b.per_z;
    } else if constexpr (J == Column::rho_z) {
        m.dsx = -(b.sx * b.per_z), m.dsy = -(b.sy * b.per_z), m.p1 = -b.per_z;
    } else if constexpr (J == Column::phi_x) {
        m.dsx = -(b.sx * b.sy), m.dsy = -A::multiply_add(b.sy, b.sy, one);
        kx = -(b.jx * b.jy), ky = -A::multiply_add(b.jy, b.jy, one);
        m.p1 = -b.sy, m.dp = -b.jy, m.q1 = -(b.jx * b.ratio);
    } else if constexpr (J == Column::phi_y) {
        m.dsx = A::multiply_add(b.sx, b.sx, one), m.dsy = b.sx * b.sy;
        kx = A::multiply_add(b.jx, b.jx, one), ky = b.jx * b.jy;
        m.p1 = b.jx + b.sx, m.dp = -b.jx, m.q2 = b.jy * b.per_ratio;
    } else {
        m.dsx = -b.sy, m.dsy = b.sx;
        kx = -b.jy, ky = b.jx;
        m.q1 = -b.ratio, m.q2 = b.per_ratio;
    }
    if (b.bends) {
        // With D of the lens: dV = (-dz/z + (dD + D R) D^-1) V + D (k - ds) u3, R the rotation's part in slopes.
        Real const r11 = J == Column::phi_y ? b.jx : zero, r12 = J == Column::phi_x ? -b.jx : J == Column::phi_z ? -one : zero;
        Real const r21 = J == Column::phi_y ? b.jy : J == Column::phi_z ? one : zero, r22 = J == Column::phi_x ? -b.jy : zero;
        Real const inverse_depth = J == Column::rho_z ? -b.per_z : J == Column::phi_x ? -b.sy : J == Column::phi_y ? b.sx : zero;
        Real const tx = b.free_x * m.dsx, ty = b.free_y * m.dsy;
        Real const n11 = A::multiply_add(b.u_xx, tx, b.u_xy * ty) + A::multiply_add(b.d00, r11, b.d01 * r21);
        Real const turned = A::multiply_add(b.u_xy, tx, b.u_yy * ty);
        Real const n12 = turned + A::multiply_add(b.d00, r12, b.d01 * r22), n21 = turned + A::multiply_add(b.d01, r11, b.d11 * r21);
        Real const n22 = A::multiply_add(b.u_yy, tx, b.v_yy * ty) + A::multiply_add(b.d01, r12, b.d11 * r22);
        m.p1 = A::multiply_add(A::multiply_add(n11, b.d11, -(n12 * b.d01)), b.per_determinant, inverse_depth);
        m.q1 = A::multiply_add(n12, b.d00, -(n11 * b.d01)) * b.per_determinant * b.ratio;
        m.q2 = A::multiply_add(n21, b.d11, -(n22 * b.d01)) * b.per_determinant * b.per_ratio;
        m.dp = A::multiply_add(A::multiply_add(n22, b.d00, -(n21 * b.d01)), b.per_determinant, inverse_depth) - m.p1;
        Real const gx = kx - tx, gy = ky - ty, dsx = m.dsx, dsy = m.dsy;
        m.kx = b.px * A::multiply_add(b.d00, gx, b.d01 * gy);
        m.ky = b.py * A::multiply_add(b.d01, gx, b.d11 * gy);
        m.dsx = A::multiply_add(b.d00, dsx, b.d01 * dsy);
        m.dsy = A::multiply_add(b.d01, dsx, b.d11 * dsy);
        return m;
    }
    m.kx = b.px * (kx - b.free_x * m.dsx);
    m.ky = b.py * (ky - b.free_y * m.dsy);
    return m;
}
} // namespace detail

/// The derivative of a splat's power by motion J. Each entry is 0 in lanes where an entry is not finite or beyond 1e30: a splat that is not
/// a number in float has no derivative.
///
/// The covariance is V V^T plus the dilation. Its forms along = -1/(2a), slope = b/a, across = -1/(2s) move by da/a = 2 v1 . dv1 / a,
/// dslope = (v1 . m + n . dv1) / a and ds = 2 n . m with m = dv2 - slope dv1. All products of v1 and n follow from the splat: v1 . v1 = a - h,
/// n . v1 = slope h, n . n = s - h - slope^2 h. So nothing cancels for a needle. The opacity does not move. `J` includes the move of the
/// Jacobian with the mean, except where its slope is clamped.
template <Column J, class A>
TILEMESH_KERNEL PowerMotion<A> power_motion(detail::MotionBasis<A> const& b) noexcept
{
    using Real = typename A::Real;
    auto const m = detail::row_motion<J, A>(b);
    Real const k = b.k, one = A::all(1.0f), two = A::all(2.0f);
    Real const turn = m.q2 + k * m.dp - k * k * m.q1, beta = m.p1 + m.dp - k * m.q1, gamma = m.ky - k * m.kx;
    Real const kh_a = k * b.h_a, v1_a = one - b.h_a;
    Real const da_a = two * (m.p1 * v1_a + m.q1 * k + m.kx * b.along_depth);
    Real const dslope = turn * v1_a + gamma * b.along_depth + (beta + m.p1 + m.q1 * k) * kh_a + m.q1 * b.nn_a + m.kx * b.across_depth;
    Real const nm_s = (turn * kh_a + beta * b.nn_a + gamma * b.across_depth) * b.a_s;
    Real const du = b.fx * m.dsx, dv = b.fy * m.dsy;
    PowerMotion<A> p{-two * b.along * du, two * b.across * (k * du - dv), -(b.along * da_a), -two * b.across * dslope, -two * b.across * nm_s};
    Real const most = A::all(1e30f), zero = A::all(0.0f);
    auto const sound = A::every(A::magnitude(p.dx_1) < most, A::magnitude(p.off_1) < most, A::magnitude(p.dx_2) < most,
                                A::magnitude(p.mixed) < most, A::magnitude(p.off_2) < most);
    p.dx_1 = A::select(sound, p.dx_1, zero);
    p.off_1 = A::select(sound, p.off_1, zero);
    p.dx_2 = A::select(sound, p.dx_2, zero);
    p.mixed = A::select(sound, p.mixed, zero);
    p.off_2 = A::select(sound, p.off_2, zero);
    return p;
}

}}} // namespace tilemesh::splat::pose
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
