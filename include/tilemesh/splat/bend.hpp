#pragma once
#include <cstdint>
#include <initializer_list>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/depth_key.hpp>
#include <tilemesh/splat/number.hpp>

TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see number.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::detail {

template <class A>
TILEMESH_KERNEL typename A::Real dot(Vector3<A> const& a, Vector3<A> const& b) noexcept
{
    return A::multiply_add(a.x, b.x, A::multiply_add(a.y, b.y, a.z * b.z));
}

/// The angle in [0, pi] of the vector (along, across), across >= 0, from the first axis; 0 for a vector of zeros. The error is below 3 ulp
/// (tests/splat/lens.cpp). Source: the polynomial of Cephes atanf (Moshier), with one division.
template <class A>
TILEMESH_KERNEL typename A::Real angle_of(typename A::Real const& along, typename A::Real const& across) noexcept
{
    using Real = typename A::Real;
    Real const size = A::magnitude(along), zero = A::all(0.0f);
    auto const steep = across > size;
    Real const less = A::select(steep, size, across), more = A::select(steep, across, size);
    auto const upper = less > A::all(0.41421356f) * more; // above tan(pi / 8): the angle less pi / 4
    Real const under = A::select(upper, less + more, more);
    Real const q = A::select(upper, less - more, less) / A::select(under > zero, under, A::all(1.0f)), s = q * q;
    Real t = A::all(8.05374449538e-2f);
    for (float const term : {-1.38776856032e-1f, 1.99777106478e-1f, -3.33329491539e-1f}) t = A::multiply_add(t, s, A::all(term));
    Real const small = A::multiply_add(t * s, q, q), first = A::select(upper, A::all(0.785398163f) + small, small);
    Real const second = A::select(steep, A::all(1.57079633f) - first, first);
    return A::select(along < zero, A::all(3.14159265f) - second, second);
}

template <class A>
TILEMESH_KERNEL typename A::Real length(Vector3<A> const& p) noexcept
{
    return A::square_root(A::multiply_add(p.z, p.z, A::multiply_add(p.x, p.x, p.y * p.y)));
}
/// The keys of the distances of means in view space: their depth for a fisheye, rounded as float32.
template <class A>
TILEMESH_KERNEL typename A::Word distance_keys(Vector3<A> const& p) noexcept
{
    return key_of<A>(length<A>(p), A::all(0.0f));
}

/// The factor of the slopes of a lens, at s = r^2: the place in the picture is `factor` times the slopes, but for the tangential part.
/// `once`, `twice`: its derivatives by s.
template <class A>
struct LensFactor {
    using Real = typename A::Real;
    Real factor, once, twice;

    TILEMESH_KERNEL LensFactor(Lens const& lens, Real const& s) noexcept
    {
        Real const one = A::all(1.0f);
        float const* const k = lens.k;
        if (lens.kind == LensKind::fov) {
            // atan(q) / q with q^2 = t^2 s; near the axis by its series, because the quotients cancel there.
            float const t = k[1], t2 = t * t, scale = t / k[0];
            Real const q2 = s * t2, r = A::square_root(q2);
            auto const near = q2 < A::all(1e-3f);
            Real const safe = A::select(near, one, q2), root = A::select(near, one, r), next = one + safe, per = one / (safe * next);
            Real const slope = safe * per, per_safe = next * per; // 1 / (1 + q^2), 1 / q^2 by one division
            Real const value = angle_of<A>(one, root) * (root * per_safe), by = 0.5f * (slope - value) * per_safe;
            Real const again = 0.5f * (-(slope * slope) - 3.0f * by) * per_safe;
            factor = scale * A::select(near, A::multiply_add(q2, A::multiply_add(q2, A::all(0.2f), A::all(-1.0f / 3)), one), value);
            once = scale * t2 *
                   A::select(near, A::multiply_add(q2, A::multiply_add(q2, A::all(-3.0f / 7), A::all(0.4f)), A::all(-1.0f / 3)), by);
            twice = scale * t2 * t2 * A::select(near, A::multiply_add(q2, A::all(-6.0f / 7), A::all(0.4f)), again);
            return;
        }
        Real const n = A::multiply_add(s, A::multiply_add(s, A::multiply_add(s, A::all(k[2]), A::all(k[1])), A::all(k[0])), one);
        factor = n;
        once = A::multiply_add(s, A::multiply_add(s, A::all(3 * k[2]), A::all(2 * k[1])), A::all(k[0]));
        twice = A::multiply_add(s, A::all(6 * k[2]), A::all(2 * k[1]));
        if (k[3] != 0 || k[4] != 0 || k[5] != 0) {
            Real const m = A::multiply_add(s, A::multiply_add(s, A::multiply_add(s, A::all(k[5]), A::all(k[4])), A::all(k[3])), one);
            Real const m1 = A::multiply_add(s, A::multiply_add(s, A::all(3 * k[5]), A::all(2 * k[4])), A::all(k[3]));
            Real const m2 = A::multiply_add(s, A::all(6 * k[5]), A::all(2 * k[4])), per_m = one / m;
            factor = n * per_m;
            once = (once - factor * m1) * per_m;
            twice = (twice - 2.0f * once * m1 - factor * m2) * per_m;
        }
    }
};

/// A lens of slopes at one pair of slopes: the place in the picture, in focal lengths, and the derivatives u_x, u_y = v_x, v_y.
template <class A>
struct BentSlopes {
    using Real = typename A::Real;
    Real u, v, d00, d01, d11;
    Real x, y; ///< where the derivatives are taken: the slopes, or the nearest ones within the limit
    typename A::Mask within;

    TILEMESH_KERNEL BentSlopes(Lens const& lens, Real const& sx, Real const& sy) noexcept
    {
        Real const r2 = A::multiply_add(sx, sx, sy * sy), most = A::all(lens.limit * lens.limit);
        within = r2 <= most;
        Real const in = A::select(within, A::all(1.0f), A::square_root(most / r2)), s = A::select(within, r2, most);
        x = sx * in, y = sy * in;
        LensFactor<A> const f(lens, s);
        Real const g = f.factor, h = 2.0f * f.once; // h: the derivative of g by r, over r
        Real const p1 = A::all(2 * lens.p[0]), p2 = A::all(2 * lens.p[1]), t = A::multiply_add(p1, y, p2 * x);
        d00 = A::multiply_add(h * x, x, g) + A::multiply_add(p2, x + x, t);
        d11 = A::multiply_add(h * y, y, g) + A::multiply_add(p1, y + y, t);
        d01 = A::multiply_add(h * x, y, A::multiply_add(p1, x, p2 * y));
        Real const dx = sx - x, dy = sy - y;
        u = A::multiply_add(x, g + t, A::multiply_add(d00, dx, A::multiply_add(d01, dy, 0.5f * p2 * s)));
        v = A::multiply_add(y, g + t, A::multiply_add(d01, dx, A::multiply_add(d11, dy, 0.5f * p1 * s)));
    }
};

/// The r in [0, most] at which a distance that rises with r is `distance`, by Newton's method between bounds. `at(r, value, slope)` gives the
/// distance and its derivative. A lane ends when it moves no more, so its bits do not depend on the others.
template <class A, class At>
TILEMESH_KERNEL typename A::Real radius_at(typename A::Real const& distance, typename A::Real const& most, At const& at) noexcept
{
    using Real = typename A::Real;
    Real low = A::all(0.0f), high = most, r = A::select(distance < most, distance, 0.5f * most);
    auto moves = r >= low;
    for (int i = 0; i < 16 && A::any(moves); ++i) {
        Real value, slope;
        at(r, value, slope);
        Real const off = value - distance;
        auto const above = off > A::all(0.0f);
        low = A::select(above, low, r), high = A::select(above, r, high);
        Real const newton = r - off / slope;
        Real const next = A::select(A::every(newton >= low, newton <= high), newton, 0.5f * (low + high)); // false for NaN
        auto const far = A::magnitude(next - r) > A::all(1e-7f) * r;
        r = A::select(moves, next, r);
        moves = A::every(moves, far);
    }
    return r;
}

/// The distance of a lens of slopes without its tangential part, by the length of the slopes.
template <class A>
struct DistanceOfSlopes {
    Lens const& lens;
    TILEMESH_KERNEL void operator()(typename A::Real const& r, typename A::Real& value, typename A::Real& slope) const noexcept
    {
        LensFactor<A> const at(lens, r * r);
        value = r * at.factor, slope = A::multiply_add(2.0f * at.once, r * r, at.factor);
    }
};

/// The slopes whose place in the picture of a lens of slopes is u, v. Without its tangential part the distance rises with r; then Newton's method
/// follows the tangential part from there. Cost: about 200 flops.
template <class A>
TILEMESH_KERNEL void unbend(Lens const& lens, typename A::Real const& u, typename A::Real const& v, typename A::Real& x,
                            typename A::Real& y) noexcept
{
    using Real = typename A::Real;
    Real const zero = A::all(0.0f), one = A::all(1.0f), most = A::all(lens.limit), distance = A::square_root(A::multiply_add(u, u, v * v));
    DistanceOfSlopes<A> const of{lens};
    Real end_distance, end_slope;
    of(most, end_distance, end_slope);
    Real const r = A::select(distance > end_distance, most + (distance - end_distance) / end_slope, radius_at<A>(distance, most, of));
    Real const scale = A::select(distance > zero, r / A::select(distance > zero, distance, one), one / LensFactor<A>(lens, zero).factor);
    x = u * scale, y = v * scale;
    if (lens.p[0] == 0 && lens.p[1] == 0) return;
    for (int i = 0; i < 6; ++i) {
        BentSlopes<A> const at(lens, x, y);
        Real const e = u - at.u, f = v - at.v, per = one / A::multiply_add(at.d00, at.d11, -(at.d01 * at.d01));
        x = A::multiply_add(A::multiply_add(at.d11, e, -(at.d01 * f)), per, x);
        y = A::multiply_add(A::multiply_add(at.d00, f, -(at.d01 * e)), per, y);
    }
}

/// A fisheye at an angle `theta` from its axis: the distance in the picture is theta times `factor`, `slope` its derivative by theta.
template <class A>
struct FisheyeDistance {
    using Real = typename A::Real;
    Real theta, factor, slope;

    TILEMESH_KERNEL FisheyeDistance(Lens const& lens, Real const& at) noexcept : theta(at)
    {
        float const* const k = lens.k;
        Real const s = theta * theta, one = A::all(1.0f);
        factor = one_plus(s, k[0], k[1], k[2], k[3], one);
        slope = one_plus(s, 3 * k[0], 5 * k[1], 7 * k[2], 9 * k[3], one);
    }

private:
    TILEMESH_KERNEL static Real one_plus(Real const& s, float a, float b, float c, float d, Real const& one) noexcept
    {
        return A::multiply_add(s, A::multiply_add(s, A::multiply_add(s, A::multiply_add(s, A::all(d), A::all(c)), A::all(b)), A::all(a)), one);
    }
};

/// The distance of a fisheye in the picture, by the angle from its axis.
template <class A>
struct DistanceOfAngle {
    Lens const& lens;
    TILEMESH_KERNEL void operator()(typename A::Real const& theta, typename A::Real& value, typename A::Real& slope) const noexcept
    {
        FisheyeDistance<A> const at(lens, theta);
        value = theta * at.factor, slope = at.slope;
    }
};

/// sin and cos of |x| <= pi; the errors are below 3e-7.
template <class A>
TILEMESH_KERNEL void sine_cosine(typename A::Real const& x, typename A::Real& sine, typename A::Real& cosine) noexcept
{
    using Real = typename A::Real;
    Real const half = 0.5f * x, s = half * half;
    Real sine_of_half = A::all(0.0f), cosine_of_half = A::all(0.0f);
    for (float const term : sine_terms) sine_of_half = A::multiply_add(sine_of_half, s, A::all(term));
    for (float const term : cosine_terms) cosine_of_half = A::multiply_add(cosine_of_half, s, A::all(term));
    sine_of_half = half * sine_of_half;
    sine = 2.0f * sine_of_half * cosine_of_half;
    cosine = A::multiply_add(-2.0f * sine_of_half, sine_of_half, A::all(1.0f));
}

/// The ray through a place in the picture: u and v from the principal point, in focal lengths. Its z is 1, or its length where the lens sees behind
/// the camera. `seen` is false where the lens shows nothing; the ray has no meaning there.
template <class A>
struct LensRay {
    using Real = typename A::Real;
    Vector3<A> ray;
    typename A::Mask seen;

    TILEMESH_KERNEL LensRay(Camera const& c, Real const& u, Real const& v) noexcept : ray{u, v, A::all(1.0f)}, seen(A::magnitude(u) < A::all(3e38f))
    {
        if (c.lens.kind == LensKind::pinhole) return;
        Real const zero = A::all(0.0f), one = A::all(1.0f);
        if (c.lens.kind == LensKind::equirectangular) {
            Real sine, cosine, flat;
            sine_cosine<A>(u, sine, cosine);
            sine_cosine<A>(v, ray.y, flat);
            ray.x = flat * sine, ray.z = flat * cosine;
            seen = A::every(A::magnitude(u) < A::all(3.1417f), A::magnitude(v) < A::all(1.5709f)); // pi and pi / 2, and their rounding
        } else if (c.lens.kind == LensKind::fisheye) {
            Real const distance = A::square_root(A::multiply_add(u, u, v * v)), most = A::all(c.lens.limit);
            Real const theta = radius_at<A>(distance, most, DistanceOfAngle<A>{c.lens});
            Real sine;
            sine_cosine<A>(theta, sine, ray.z);
            Real const outward = A::select(distance > zero, sine / A::select(distance > zero, distance, one), one);
            ray.x = u * outward, ray.y = v * outward;
            FisheyeDistance<A> const end(c.lens, most);
            seen = distance < most * end.factor;
        } else {
            unbend<A>(c.lens, u, v, ray.x, ray.y);
            if (c.lens.ends != 0) seen = A::multiply_add(ray.x, ray.x, ray.y * ray.y) < A::all(c.lens.limit * c.lens.limit);
        }
    }
};

/// A lens that bends, at one mean in view space: where the mean is in the picture, in focal lengths, and the Jacobian there as M [across; down],
/// with `across` and `down` as covectors of view space and M in pixels per unit of length.
template <class A>
struct Bent {
    using Real = typename A::Real;
    Real u, v;
    Vector3<A> across, down;
    Real mix[4];             ///< M, row by row
    Real x, y;               ///< of a lens of slopes: those of the Jacobian
    Real depth;              ///< z, or the distance of a fisheye
    typename A::Mask seen;

    Bent() noexcept = default;
    /// `p`: the mean in view space.
    TILEMESH_KERNEL Bent(Camera const& c, Vector3<A> const& p) noexcept
    {
        if (c.lens.kind == LensKind::fisheye)
            by_angle(c, p);
        else
            by_slopes(c, p);
    }
    /// More than any entry of V per unit of an axis's length.
    TILEMESH_KERNEL Real steepest() const noexcept
    {
        Real const m = A::magnitude(mix[0]) + A::magnitude(mix[1]) + A::magnitude(mix[2]) + A::magnitude(mix[3]);
        return m * (total(across) + total(down));
    }

private:
    TILEMESH_KERNEL static Real total(Vector3<A> const& w) noexcept { return A::magnitude(w.x) + A::magnitude(w.y) + A::magnitude(w.z); }
    TILEMESH_KERNEL void by_slopes(Camera const& c, Vector3<A> const& p) noexcept
    {
        Real const zero = A::all(0.0f), one = A::all(1.0f);
        BentSlopes<A> const at(c.lens, p.x / p.z, p.y / p.z);
        u = at.u, v = at.v, x = at.x, y = at.y;
        across = {one, zero, -x};
        down = {zero, one, -y};
        Real const px = A::all(c.fx) / p.z, py = A::all(c.fy) / p.z;
        mix[0] = px * at.d00, mix[1] = px * at.d01, mix[2] = py * at.d01, mix[3] = py * at.d11;
        depth = p.z;
        seen = depth > A::all(c.near_depth);
        if (c.lens.ends != 0) seen = A::every(seen, at.within);
    }
    TILEMESH_KERNEL void by_angle(Camera const& c, Vector3<A> const& p) noexcept
    {
        Real const zero = A::all(0.0f), one = A::all(1.0f);
        Real const rho2 = A::multiply_add(p.x, p.x, p.y * p.y), all = A::multiply_add(p.z, p.z, rho2), rho = A::square_root(rho2);
        auto const off = rho > zero;
        Real const safe = A::select(off, rho, one), ex = A::select(off, p.x / safe, one), ey = A::select(off, p.y / safe, zero);
        FisheyeDistance<A> const at(c.lens, angle_of<A>(p.z, rho));
        Real const distance = at.theta * at.factor;
        u = distance * ex, v = distance * ey;
        // Outward, (z e - rho e_z) slope / |p|^2; around, the distance over rho.
        x = y = zero;
        across = {p.z * ex, p.z * ey, -rho};
        down = {-ey, ex, zero};
        Real const outward = at.slope / all, around = A::select(off, distance / safe, one / p.z);
        Real const fx = A::all(c.fx), fy = A::all(c.fy);
        mix[0] = fx * ex * outward, mix[1] = -(fx * ey * around);
        mix[2] = fy * ey * outward, mix[3] = fy * ex * around;
        depth = length<A>(p);
        seen = A::every(depth > A::all(c.near_depth), depth < A::all(1e37f), at.theta < A::all(c.lens.limit)); // as `huge` in project_words
    }
};

/// The second derivatives of a lens of slopes at x, y, without its limit: u_xx, u_xy = v_xx, u_yy = v_xy, v_yy.
template <class A>
struct LensCurvature {
    using Real = typename A::Real;
    Real u_xx, u_xy, u_yy, v_yy;

    TILEMESH_KERNEL LensCurvature(Lens const& lens, Real const& x, Real const& y) noexcept
    {
        Real const xx = x * x, yy = y * y, four = A::all(4.0f), six = A::all(6.0f), two = A::all(2.0f);
        LensFactor<A> const f(lens, xx + yy);
        Real const p1 = A::all(2 * lens.p[0]), p2 = A::all(2 * lens.p[1]);
        u_xx = x * A::multiply_add(four * xx, f.twice, six * f.once) + A::all(3.0f) * p2;
        u_xy = y * A::multiply_add(four * xx, f.twice, two * f.once) + p1;
        u_yy = x * A::multiply_add(four * yy, f.twice, two * f.once) + p2;
        v_yy = y * A::multiply_add(four * yy, f.twice, six * f.once) + A::all(3.0f) * p1;
    }
};

/// The second derivatives of a fisheye at a point of view space. Its picture is f_k p_k phi with phi = distance / rho, so it suffices to know how phi
/// moves: `slope` is its gradient, and `times(v)` its second derivatives times v.
template <class A>
struct FisheyeCurvature {
    using Real = typename A::Real;
    Vector3<A> p, slope;
    Real phi;
    Real a, b, c, zz; ///< of the second derivatives: a + b x^2, a + b y^2, zz on the diagonal; b x y, c x, c y beside it

    FisheyeCurvature() noexcept = default;
    TILEMESH_KERNEL FisheyeCurvature(Lens const& lens, Vector3<A> const& at) noexcept : p(at)
    {
        float const* const k = lens.k;
        Real const zero = A::all(0.0f), one = A::all(1.0f), two = A::all(2.0f);
        Real const rho2 = A::multiply_add(p.x, p.x, p.y * p.y), rho = A::square_root(rho2);
        Real const all = A::multiply_add(p.z, p.z, rho2), per2 = one / all, per4 = per2 * per2;
        auto const near = A::every(p.z > zero, rho2 < A::all(1e-3f) * (p.z * p.z)); // by a series, because the quotients cancel there
        FisheyeDistance<A> const of(lens, angle_of<A>(p.z, rho));
        Real const theta = of.theta, once = of.slope, s = theta * theta;
        Real const twice = theta * A::multiply_add(s, A::multiply_add(s, A::multiply_add(s, A::all(72 * k[3]), A::all(42 * k[2])), A::all(20 * k[1])),
                                                   A::all(6 * k[0]));
        Real const safe = A::select(near, one, rho), per_rho = one / safe, per_rho2 = per_rho * per_rho, far_phi = theta * of.factor * per_rho;
        Real const far_a = (once * p.z * per2 - far_phi) * per_rho2;
        Real const far_b = ((twice * p.z * p.z * per_rho - two * once * p.z) * per4 - A::all(3.0f) * far_a) * per_rho2;
        Real const far_c = (two * once - twice * p.z * per_rho) * per4;
        // phi = 1/z + c1 rho^2 / z^3 + c2 rho^4 / z^5
        float const c1 = k[0] - 1.0f / 3, c2 = k[1] - k[0] + 0.2f;
        Real const per_z = one / A::select(near, p.z, one), per_z2 = per_z * per_z, q2 = rho2 * per_z2, per_z3 = per_z2 * per_z;
        phi = A::select(near, per_z * A::multiply_add(q2, A::multiply_add(q2, A::all(c2), A::all(c1)), one), far_phi);
        a = A::select(near, per_z3 * A::multiply_add(q2, A::all(4 * c2), A::all(2 * c1)), far_a);
        b = A::select(near, A::all(8 * c2) * (per_z3 * per_z2), far_b);
        c = A::select(near, per_z2 * per_z2 * A::multiply_add(q2, A::all(-20 * c2), A::all(-6 * c1)), far_c);
        zz = (twice * rho + two * once * p.z) * per4;
        slope = {a * p.x, a * p.y, -(once * per2)};
    }
    /// Row k of the Jacobian: f_k (phi e_k + p_k slope).
    TILEMESH_KERNEL Vector3<A> row(int k, float f) const noexcept
    {
        Real const along = f * (k == 0 ? p.x : p.y);
        Vector3<A> j{along * slope.x, along * slope.y, along * slope.z};
        (k == 0 ? j.x : j.y) = (k == 0 ? j.x : j.y) + f * phi;
        return j;
    }
    TILEMESH_KERNEL Vector3<A> times(Vector3<A> const& v) const noexcept
    {
        Real const along = b * A::multiply_add(p.x, v.x, p.y * v.y);
        return {A::multiply_add(a, v.x, A::multiply_add(along, p.x, c * p.x * v.z)),
                A::multiply_add(a, v.y, A::multiply_add(along, p.y, c * p.y * v.z)),
                A::multiply_add(c, A::multiply_add(p.x, v.x, p.y * v.y), zz * v.z)};
    }
};

}}} // namespace tilemesh::splat::detail
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
