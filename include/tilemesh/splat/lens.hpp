#pragma once
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <tilemesh/config.hpp>
#include <type_traits>

TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace splat {

/// How a lens bends the picture. x = X / Z and y = Y / Z are the slopes of a point in view space, r their length, theta its angle from the
/// optical axis, and (u, v) its place in the picture: the pixel is (fx u + cx, fy v + cy).
enum class LensKind : std::uint32_t {
    pinhole, ///< u = x, v = y
    /// Radial and tangential (Brown; OpenCV's rational model): with s = r^2 and g = (1 + k1 s + k2 s^2 + k3 s^3) / (1 + k4 s + k5 s^2 +
    /// k6 s^3), u = g x + 2 p1 x y + p2 (s + 2 x^2), v = g y + p1 (s + 2 y^2) + 2 p2 x y.
    opencv,
    /// Kannala and Brandt 2006, OpenCV's fisheye: the distance from the centre is theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4
    /// theta^8). It sees behind z = 0: depth is the distance from the camera, and so is the near plane's.
    fisheye,
    fov, ///< Devernay and Faugeras 2001: the distance from the centre is atan(2 r tan(omega / 2)) / omega; k[0] is omega, in radians
    /// A panorama: u is the azimuth atan2(X, Z), v the latitude asin(Y / |p|), in radians. It sees all round, so depth is the distance, as a
    /// fisheye's. Exact rays draw it (splat/exact.hpp): a conic is no picture of a Gaussian at a pole, or on both sides of the seam.
    equirectangular
};

inline constexpr char const* lens_names[] = {"pinhole", "opencv", "fisheye", "fov", "equirectangular"}; ///< by LensKind

/// Is depth the distance from the camera, because the lens sees behind z = 0?
constexpr bool sees_behind(LensKind kind) noexcept { return kind == LensKind::fisheye || kind == LensKind::equirectangular; }

/// The lens of a camera. All zeros: a pinhole. A lens of coefficients that are all 0 is no pinhole for these types, but draws the same
/// splats up to rounding (`opencv`).
///
/// `limit` and `ends` follow from the camera (`bound_lens`, which `make_view` calls), and k[1] of `fov`, 2 tan(omega / 2); leave them 0. Up to
/// `limit`, a radius r of slopes or an angle of a fisheye, the lens is what its coefficients say. Beyond it a lens of slopes goes on
/// linearly, because a polynomial has no meaning there: the limit is the widest pixel of the picture. If the lens folds (its radius ceases to
/// grow) within 1.3 times the widest pixel, the limit is 0.95 times the fold, and what lies beyond is not drawn (`ends`). A fisheye ends at
/// its fold, at most at 0.999 pi, and a lens whose picture shows all that it sees at a slope of 64. A pixel without a ray shows the splats
/// that reach it, or the background; a mask leaves it out of comparisons. Do not change the size or the focal lengths of a camera whose limit
/// is set (that of a view).
struct Lens {
    LensKind kind;
    float k[6]; ///< opencv: k1 to k6; fisheye: k1 to k4; fov: omega
    float p[2]; ///< opencv: p1, p2
    float limit;
    std::uint32_t ends;
};
static_assert(sizeof(Lens) == 44 && std::is_trivial_v<Lens>, "a lens is plain words");

/// A rolling shutter: the rows of a picture are exposed one after the other, and the camera moves meanwhile. Time is v = (y - cy) / fy, the place
/// of a row in focal lengths, so windows and other sizes of a picture have the same numbers. The pose of a camera is that of the row v = 0;
/// in the axes of that pose, the camera of row v has turned by the rotation vector v `turn` (radians) and moved by v `move` (world
/// units): p in view space is there exp(-v turn) (p - v move). All zeros: the picture is exposed at once.
///
/// A splat is drawn as the camera of its mean's row sees it, with the shear that the motion gives it (`splat/projection.hpp`); colours that
/// depend on the direction are those of the row v = 0. What moves down the picture as fast as the rows are read is not drawn. `reach`, the
/// largest |v| of a row, follows from the camera as a lens's limit does; leave it 0. At most 1 radian of turn at `reach`.
///
/// The mean's row is found by three rounds from the row v = 0, which must see the mean. The rounds are off by less than a pixel while the
/// picture moves by less than a fifth of a row in the time of a row; a hand does not turn so fast.
struct Shutter {
    float turn[3], move[3];
    float reach;

    bool rolls() const noexcept { return turn[0] != 0 || turn[1] != 0 || turn[2] != 0 || move[0] != 0 || move[1] != 0 || move[2] != 0; }
};
static_assert(sizeof(Shutter) == 28 && std::is_trivial_v<Shutter>, "a shutter is plain words");

/// The cameras that a kernel projects through: pinholes alone, or any. A program of pinholes has no code for lenses. A program's
/// parameters say which (`bends`); a host refuses a lens that its tiles do not know.
struct Pinhole {
    static constexpr bool bends = false;
};
struct AnyLens {
    static constexpr bool bends = true;
};
template <class Parameters>
using OpticsOf = std::conditional_t<Parameters::bends, AnyLens, Pinhole>;

/// The distance from the centre by the radius of slopes or the angle `r`, in focal lengths, and its derivative.
template <class T>
void lens_radius(Lens const& lens, T r, T& distance, T& derivative) noexcept
{
    T const s = r * r, one = 1;
    T const k1 = lens.k[0], k2 = lens.k[1], k3 = lens.k[2], k4 = lens.k[3], k5 = lens.k[4], k6 = lens.k[5];
    if (lens.kind == LensKind::fisheye) {
        distance = r * (one + s * (k1 + s * (k2 + s * (k3 + s * k4))));
        derivative = one + s * (3 * k1 + s * (5 * k2 + s * (7 * k3 + s * 9 * k4)));
    } else if (lens.kind == LensKind::fov) {
        T const t = 2 * std::tan(k1 / 2);
        distance = std::atan(r * t) / k1;
        derivative = t / ((one + s * t * t) * k1);
    } else if (lens.kind == LensKind::opencv) {
        T const n = one + s * (k1 + s * (k2 + s * k3)), m = one + s * (k4 + s * (k5 + s * k6));
        T const by_s = k1 + s * (2 * k2 + s * 3 * k3), m_by_s = k4 + s * (2 * k5 + s * 3 * k6);
        distance = r * n / m;
        derivative = n / m + 2 * s * (by_s * m - n * m_by_s) / (m * m);
    } else {
        distance = r, derivative = one;
    }
}

namespace detail {
/// The series of sin x / x and of cos x in x^2, from the highest power down.
inline constexpr float sine_terms[] = {-7.6471637e-13f, 1.6059044e-10f, -2.5052108e-8f, 2.7557319e-6f,
                                       -1.9841270e-4f,  8.3333333e-3f,  -0.16666667f,   1.0f};
inline constexpr float cosine_terms[] = {4.7794773e-14f, -1.1470746e-11f, 2.0876757e-9f, -2.7557319e-7f, 2.4801587e-5f, -1.3888889e-3f,
                                         4.1666667e-2f,  -0.5f,           1.0f};
/// 2 tan(omega / 2), as the quotient of two series; the error is below 2e-6 of it up to 3 radians, and 1e-4 at 3.1.
inline float twice_tangent(float omega) noexcept
{
    float const x = 0.5f * omega, s = x * x;
    float sine = 0, cosine = 0;
    for (float const term : sine_terms) sine = sine * s + term;
    for (float const term : cosine_terms) cosine = cosine * s + term;
    return 2.0f * x * sine / cosine;
}
} // namespace detail

/// Slopes to the picture through a lens of slopes, in focal lengths, with the derivatives u_x, u_y = v_x, v_y. Without its limit.
template <class T>
void bend_slopes(Lens const& lens, T x, T y, T (&at)[2], T (&by)[3]) noexcept
{
    T const s = x * x + y * y, r = std::sqrt(s), p1 = lens.p[0], p2 = lens.p[1];
    T distance, derivative, g = 1, h = 0;
    lens_radius<T>(lens, r, distance, derivative);
    if (r > T(1e-6f)) g = distance / r, h = (derivative - g) / s;
    else g = derivative;
    at[0] = x * g + 2 * p1 * x * y + p2 * (s + 2 * x * x);
    at[1] = y * g + p1 * (s + 2 * y * y) + 2 * p2 * x * y;
    by[0] = g + h * x * x + 2 * p1 * y + 6 * p2 * x;
    by[1] = h * x * y + 2 * p1 * x + 2 * p2 * y;
    by[2] = g + h * y * y + 6 * p1 * y + 2 * p2 * x;
}

/// What a search from the axis outward finds in a lens: the radius of slopes, or the angle of a fisheye, at which the picture is `distance` focal
/// lengths from its centre; and the fold, the first radius at which that distance ceases to grow. What is not found is the end of the search:
/// slopes of 64 (89.1 degrees), or 0.999 pi. `is_fold`: there is a fold, not the end.
template <class T>
struct LensReach {
    T radius, fold;
    bool is_fold;
};
template <class T>
LensReach<T> reach_of(Lens const& lens, T distance) noexcept
{
    bool const angle = lens.kind == LensKind::fisheye;
    T const most = angle ? T(3.1384510610f) : T(64);
    LensReach<T> found{most, most, false};
    T before = 0, d, slope;
    auto const halve = [&](T low, T high, bool for_fold) {
        for (int i = 0; i < 60; ++i) {
            T const middle = (low + high) / 2;
            lens_radius<T>(lens, middle, d, slope);
            bool const inside = for_fold ? slope > 0 && d >= 0 : d < distance;
            (inside ? low : high) = middle;
        }
        return low;
    };
    for (T r = 0; r < most; before = r) {
        T const step = (1 + r) / 128;
        r = r + step < most ? r + step : most;
        lens_radius<T>(lens, r, d, slope);
        bool const folds = !(slope > 0 && d >= 0);
        T const end = folds ? found.fold = halve(before, r, true) : r;
        if (folds) lens_radius<T>(lens, end, d, slope);
        if (found.radius == most && d >= distance) found.radius = halve(before, end, false);
        found.is_fold = folds;
        if (folds || (found.radius < most && r > T(1.4f) * found.radius)) break;
    }
    return found;
}

}}} // namespace tilemesh::splat
TILEMESH_EXACT_END
