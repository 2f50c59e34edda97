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

/// A lens that bends, at one mean in view space: where the mean is in the picture, in focal lengths, and the Jacobian there as M [across; down],
/// with `across` and `down` as covectors of view space and M in pixels per unit of length.
template <class A>
struct Bent {
    using Real = typename A::Real;
    Real u, v;
    Vector3<A> across, down;
    Real mix[4];             ///< M, row by row
    Real depth;              ///< z, or the distance of a fisheye
    typename A::Mask seen;

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
        Lens const& lens = c.lens;
        Real const zero = A::all(0.0f), one = A::all(1.0f), x = p.x / p.z, y = p.y / p.z;
        Real const r2 = A::multiply_add(x, x, y * y), most = A::all(lens.limit * lens.limit);
        auto const beyond = r2 > most;
        Real const in = A::select(beyond, A::square_root(most / r2), one);
        Real const x0 = x * in, y0 = y * in, s = A::select(beyond, most, r2);
        Real g = one, h = zero; // the factor of the slopes, and its derivative by r over r
        Real const p1 = A::all(2 * lens.p[0]), p2 = A::all(2 * lens.p[1]);
        if (lens.kind == LensKind::fov) {
            float const t = twice_tangent(lens.k[0]), per_omega = 1.0f / lens.k[0];
            Real const r = A::square_root(s), none = A::all(1e-12f);
            auto const off = r > none;
            Real const slope = A::all(t * per_omega) / A::multiply_add(s, A::all(t * t), one);
            g = A::select(off, angle_of<A>(one, r * t) * per_omega / A::select(off, r, one), A::all(t * per_omega));
            h = A::select(off, (slope - g) / A::select(off, s, one), zero);
        } else {
            float const* const k = lens.k;
            Real const n = A::multiply_add(s, A::multiply_add(s, A::multiply_add(s, A::all(k[2]), A::all(k[1])), A::all(k[0])), one);
            Real const by_s = A::multiply_add(s, A::multiply_add(s, A::all(3 * k[2]), A::all(2 * k[1])), A::all(k[0]));
            g = n, h = 2.0f * by_s;
            if (k[3] != 0 || k[4] != 0 || k[5] != 0) {
                Real const m = A::multiply_add(s, A::multiply_add(s, A::multiply_add(s, A::all(k[5]), A::all(k[4])), A::all(k[3])), one);
                Real const m_by_s = A::multiply_add(s, A::multiply_add(s, A::all(3 * k[5]), A::all(2 * k[4])), A::all(k[3]));
                Real const per_m = one / m;
                g = n * per_m;
                h = 2.0f * (by_s - g * m_by_s) * per_m;
            }
        }
        Real const t = A::multiply_add(p1, y0, p2 * x0);
        Real const d00 = A::multiply_add(h * x0, x0, g) + A::multiply_add(p2, x0 + x0, t);
        Real const d11 = A::multiply_add(h * y0, y0, g) + A::multiply_add(p1, y0 + y0, t);
        Real const d01 = A::multiply_add(h * x0, y0, A::multiply_add(p1, x0, p2 * y0));
        u = A::multiply_add(x0, g + t, A::multiply_add(d00, x - x0, A::multiply_add(d01, y - y0, 0.5f * p2 * s)));
        v = A::multiply_add(y0, g + t, A::multiply_add(d01, x - x0, A::multiply_add(d11, y - y0, 0.5f * p1 * s)));
        across = {one, zero, -x0};
        down = {zero, one, -y0};
        Real const px = A::all(c.fx) / p.z, py = A::all(c.fy) / p.z;
        mix[0] = px * d00, mix[1] = px * d01, mix[2] = py * d01, mix[3] = py * d11;
        depth = p.z;
        seen = depth > A::all(c.near_depth);
        if (lens.ends != 0) seen = A::every(seen, r2 < most);
    }
    TILEMESH_KERNEL void by_angle(Camera const& c, Vector3<A> const& p) noexcept
    {
        Lens const& lens = c.lens;
        float const* const k = lens.k;
        Real const zero = A::all(0.0f), one = A::all(1.0f);
        Real const rho2 = A::multiply_add(p.x, p.x, p.y * p.y), all = A::multiply_add(p.z, p.z, rho2), rho = A::square_root(rho2);
        auto const off = rho > zero;
        Real const safe = A::select(off, rho, one), ex = A::select(off, p.x / safe, one), ey = A::select(off, p.y / safe, zero);
        Real const theta = angle_of<A>(p.z, rho), s = theta * theta;
        Real const g = A::multiply_add(
            s, A::multiply_add(s, A::multiply_add(s, A::multiply_add(s, A::all(k[3]), A::all(k[2])), A::all(k[1])), A::all(k[0])), one);
        Real const slope = A::multiply_add(
            s,
            A::multiply_add(s, A::multiply_add(s, A::multiply_add(s, A::all(9 * k[3]), A::all(7 * k[2])), A::all(5 * k[1])), A::all(3 * k[0])),
            one);
        Real const distance = theta * g;
        u = distance * ex, v = distance * ey;
        // Outward, (z e - rho e_z) slope / |p|^2; around, the distance over rho.
        across = {p.z * ex, p.z * ey, -rho};
        down = {-ey, ex, zero};
        Real const outward = slope / all, around = A::select(off, distance / safe, one / p.z);
        Real const fx = A::all(c.fx), fy = A::all(c.fy);
        mix[0] = fx * ex * outward, mix[1] = -(fx * ey * around);
        mix[2] = fy * ey * outward, mix[3] = fy * ex * around;
        depth = length<A>(p);
        seen = A::every(depth > A::all(c.near_depth), theta < A::all(lens.limit));
    }
    /// 2 tan(omega / 2), by tan = sin / cos of series that are good to a float up to 3 radians.
    static float twice_tangent(float omega) noexcept
    {
        float const x = 0.5f * omega, s = x * x;
        float sine = 0, cosine = 0;
        for (float const term : {-7.6471637e-13f, 1.6059044e-10f, -2.5052108e-8f, 2.7557319e-6f, -1.9841270e-4f, 8.3333333e-3f, -0.16666667f, 1.0f})
            sine = sine * s + term;
        for (float const term : {4.7794773e-14f, -1.1470746e-11f, 2.0876757e-9f, -2.7557319e-7f, 2.4801587e-5f, -1.3888889e-3f, 4.1666667e-2f, -0.5f, 1.0f})
            cosine = cosine * s + term;
        return 2.0f * x * sine / cosine;
    }
};

}}} // namespace tilemesh::splat::detail
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
