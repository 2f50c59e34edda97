#pragma once
#include <cmath>
#include <cstdint>
#include <limits>
#include <tilemesh/splat/projection.hpp>

/// A Gaussian as exact rays see it. The alpha of a pixel is the largest that the Gaussian has anywhere along the pixel's ray, so no Jacobian is
/// in it but for the picture's dilation. With a conic (`project`), a Gaussian that is large and near has another shape than it has in space.
///
/// Take lengths in units of the mean's distance. Across the ray of the mean, the dilated covariance is the 2 x 2 matrix C with the inverse S. Given
/// a place x across, the depth has the mean -g . x and the variance c. Then a ray that is d along and x across comes as near as m standard
/// deviations, with m^2 = x S x / ((d + g . x)^2 + c x S x). All words are sums of squares or regressions, so nothing cancels for a needle.
TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace splat {

/// A splat with what its response needs. `columns` and `rows` hold every pixel whose ray has an alpha of alpha_min or more. `along`, `slope` and
/// `across` are unused.
struct ExactSplat : Splat {
    /// A ray differs by D from `towards`, the ray of the mean. x = first . D, y = second . D, t = 1 + depth . D; the power is -q / (t^2 + spread q)
    /// with q = x^2 + y^2. If t is negative, the nearest point is behind the camera.
    float towards[3] = {}, first[3] = {}, second[3] = {}, depth[3] = {};
    float spread = 0;
};
static_assert(sizeof(ExactSplat) == 108, "a splat of exact rays is 27 words");

namespace detail {
/// The columns of a Gaussian's dilated covariance C = F F^T, in view space and in units of the mean's distance.
struct ExactFactor {
    Float3 column[5];
    /// The products of a covector with the columns.
    void times(Float3 const& w, float (&to)[5]) const noexcept
    {
        for (int i = 0; i < 5; ++i) to[i] = dot(w, column[i]);
    }
};
inline float dot5(float const (&a)[5], float const (&b)[5]) noexcept
{
    float sum = 0;
    for (int i = 5; i-- > 0;) sum = multiply_add(a[i], b[i], sum);
    return sum;
}

/// The quotients w x / e x that points x of a Gaussian's ellipsoid have; false if they have no bounds. w p = 0 for the mean p, and e p > 0.
/// `radius2`: the square of the ellipsoid's radius in standard deviations. They solve (w - r e) p = +-radius |(w - r e) F|.
struct Bounds {
    float low, high;
};
inline bool range_of(ExactFactor const& f, Float3 const& w, Float3 const& e, float e_of_mean, float radius2, Bounds& out) noexcept
{
    float across[5], along[5];
    f.times(w, across), f.times(e, along);
    float const all = e_of_mean * e_of_mean, less = all - radius2 * dot5(along, along), middle = radius2 * dot5(across, along);
    if (!(less > 0.01f * all)) return false; // a cone of 84 degrees to a side; nearer to 90 its border is too uncertain
    float const root = std::sqrt(multiply_add(middle, middle, radius2 * dot5(across, across) * less));
    float const margin = 1e-4f * root / less; // of roundings: below 2e-5, because a difference loses at most a factor of 100
    out = {(-middle - root) / less - margin, (-middle + root) / less + margin};
    return out.high - out.low < 1e9f;
}

/// A part of a ring around a lens's axis, in its picture. It reaches from `inner` to `outer` focal lengths from the axis, and to each side of the
/// direction (cosine, sine) by an angle with `cosine_off` and `sine_off`. `cosine_off` is -1 for the whole ring.
struct RingPart {
    float inner, outer, cosine, sine, cosine_off, sine_off;
    /// The largest first coordinate, where the ring's middle is turned to (c, s).
    float most(float c, float s) const noexcept
    {
        if (cosine_off < 0 || c >= cosine_off) return outer;
        float const end = multiply_add(c, cosine_off, std::fabs(s) * sine_off); // of the border that is nearer to the first axis
        return end > 0 ? outer * end : inner * end;
    }
    Bounds across() const noexcept { return {-most(-cosine, sine), most(cosine, sine)}; }
    Bounds down() const noexcept { return {-most(-sine, cosine), most(sine, cosine)}; }
};

/// The angles from an axis, and around it, that directions in a box have: e + a u + b v with |b| <= `side`, where e is at the angle with `cosine`,
/// `sine` from the axis, and u leads away from it. Angles along great circles have their extremes at the ends of a line, or at a pole.
struct PolarBox {
    float low, high;            ///< angles from the axis
    float cosine_off, sine_off; ///< of the angle around it, to each side; -1 and 0 if the box holds a pole
};
inline PolarBox polar_box(float cosine, float sine, Bounds const& a, float side) noexcept
{
    PolarBox box{4, 0, -1, 0};
    float least = std::numeric_limits<float>::infinity();
    for (float const at : {a.low, a.high}) {
        float const along = multiply_add(-at, sine, cosine), outward = multiply_add(at, cosine, sine);
        least = outward < least ? outward : least;
        for (float const b : {0.0f, side}) {
            float const angle = angle_of<OneFloat>(along, std::sqrt(multiply_add(outward, outward, b * b)));
            box.low = angle < box.low ? angle : box.low, box.high = angle > box.high ? angle : box.high;
        }
    }
    box.low -= 2e-6f, box.high += 2e-6f; // three ulp of pi and the roundings before
    if (least > 1e-5f) {
        float const tangent = side / least * 1.00001f, length = std::sqrt(multiply_add(tangent, tangent, 1.0f));
        box.cosine_off = 1 / length, box.sine_off = tangent / length;
    } else if (cosine >= 0) {
        box.low = 0;
    } else {
        box.high = 3.1415927f;
    }
    return box;
}

/// The pixels of a picture whose rays may meet a Gaussian's ellipsoid, as spans; all if it may fill the picture. p: the mean's direction.
struct ExactBox {
    std::int32_t columns, rows; ///< x0 | x1 << 16; 0: none

    ExactBox(ExactFactor const& f, Camera const& c, Float3 const& p, float radius2) noexcept
        : columns(static_cast<std::int32_t>(c.width << 16)), rows(static_cast<std::int32_t>(c.height << 16))
    {
        if (c.lens.kind == LensKind::pinhole) {
            float const x = p.x / p.z, y = p.y / p.z;
            Bounds across, down;
            if (!range_of(f, {1, 0, -x}, {0, 0, 1}, p.z, radius2, across) || !range_of(f, {0, 1, -y}, {0, 0, 1}, p.z, radius2, down)) return;
            set(c, {x + across.low, x + across.high}, {y + down.low, y + down.high});
        } else if (c.lens.kind == LensKind::equirectangular) {
            of_panorama(f, c, p, radius2);
        } else if (c.lens.kind == LensKind::fisheye) {
            of_fisheye(f, c, p, radius2);
        } else {
            of_slopes(f, c, p, radius2);
        }
    }

private:
    /// From places in focal lengths. The margin: pixels' rays, and what Newton's method leaves of them.
    void set(Camera const& c, Bounds const& across, Bounds const& down) noexcept
    {
        constexpr float margin = 0.02f;
        auto const span = [](Bounds const& r, float focal, float centre, std::uint32_t size) noexcept {
            float const most = 2 * static_cast<float>(size); // of what is far outside, only that it is
            float const low = clamp<OneFloat>(multiply_add(focal, r.low, centre), -most, most);
            float const half = 0.5f * (clamp<OneFloat>(multiply_add(focal, r.high, centre), -most, most) - low);
            return pixel_span<OneFloat>(low + half, multiply_add(1e-5f, half, half) + margin, size);
        };
        columns = span(across, c.fx, c.cx, c.width), rows = span(down, c.fy, c.cy, c.height);
    }
    /// Bounds of the mean's direction in the plane of directions: away from the axis with the cosine, sine, and to the side.
    static bool of_directions(ExactFactor const& f, Float3 const& p, Float3 const& away, Float3 const& side, float radius2, Bounds& a,
                              float& b) noexcept
    {
        Bounds to_side;
        if (!range_of(f, away, p, 1, radius2, a) || !range_of(f, side, p, 1, radius2, to_side)) return false;
        b = -to_side.low > to_side.high ? -to_side.low : to_side.high;
        return true;
    }
    void of_panorama(ExactFactor const& f, Camera const& c, Float3 const& p, float radius2) noexcept
    {
        float const flat = std::sqrt(multiply_add(p.x, p.x, p.z * p.z)), safe = flat > 0 ? flat : 1, ex = flat > 0 ? p.x / safe : 0;
        float const ez = flat > 0 ? p.z / safe : 1; // the axis points down, and latitudes grow with y
        Bounds a;
        float side;
        if (!of_directions(f, p, {p.y * ex, -flat, p.y * ez}, {ez, 0, -ex}, radius2, a, side)) return;
        PolarBox const box = polar_box(p.y, flat, a, side);
        constexpr float half_turn = 3.1415927f, quarter = 1.5707964f;
        float const azimuth = p.x < 0 ? -angle_of<OneFloat>(p.z, -p.x) : angle_of<OneFloat>(p.z, p.x);
        float const off = box.cosine_off < 0 ? 4 : angle_of<OneFloat>(box.cosine_off, box.sine_off) + 2e-6f;
        bool const seam = !(azimuth - off > -half_turn && azimuth + off < half_turn);
        set(c, seam ? Bounds{-4, 4} : Bounds{azimuth - off, azimuth + off}, {quarter - box.high, quarter - box.low});
    }
    void of_fisheye(ExactFactor const& f, Camera const& c, Float3 const& p, float radius2) noexcept
    {
        float const rho = std::sqrt(multiply_add(p.x, p.x, p.y * p.y)), safe = rho > 0 ? rho : 1, limit = c.lens.limit;
        float const ex = rho > 0 ? p.x / safe : 1, ey = rho > 0 ? p.y / safe : 0;
        Bounds a;
        float side;
        if (!of_directions(f, p, {p.z * ex, p.z * ey, -rho}, {-ey, ex, 0}, radius2, a, side)) return;
        PolarBox const box = polar_box(p.z, rho, a, side);
        float const low = box.low > 0 ? box.low : 0, high = box.high < limit ? box.high : limit;
        if (!(low < high)) return clear();
        RingPart const part{distance_at(c.lens, low), distance_at(c.lens, high), ex, ey, box.cosine_off, box.sine_off};
        set(c, part.across(), part.down());
    }
    static float distance_at(Lens const& lens, float theta) noexcept
    {
        float value, slope;
        DistanceOfAngle<OneFloat>{lens}(theta, value, slope);
        return value;
    }
    void clear() noexcept { columns = rows = 0; }

    /// The Jacobian of a lens of slopes is symmetric and positive definite up to its limit (scene::check_camera). So across a box of slopes, u
    /// has its extremes at the left and the right edge, and v at the others. No pixel's ray is beyond the limit, so an edge that is farther out
    /// is as far as the picture.
    void of_slopes(ExactFactor const& f, Camera const& c, Float3 const& p, float radius2) noexcept
    {
        float const x = p.x / p.z, y = p.y / p.z;
        Bounds across, down;
        if (!range_of(f, {1, 0, -x}, {0, 0, 1}, p.z, radius2, across) || !range_of(f, {0, 1, -y}, {0, 0, 1}, p.z, radius2, down)) return;
        across = {x + across.low, x + across.high}, down = {y + down.low, y + down.high};
        float const p1 = c.lens.p[0], p2 = c.lens.p[1];
        Bounds u, v;
        if (!edge(c.lens, -across.low, {-down.high, -down.low}, -p1, -p2, u.low) || !edge(c.lens, across.high, down, p1, p2, u.high) ||
            !edge(c.lens, -down.low, {-across.high, -across.low}, -p2, -p1, v.low) || !edge(c.lens, down.high, across, p2, p1, v.high))
            return clear();
        set(c, {-u.low, u.high}, {-v.low, v.high});
    }
    /// The most of u = x g + 2 p1 x y + p2 (3 x^2 + y^2) at the edge x of a box, for `ys`, where that may be within the limit; false if nothing is.
    static bool edge(Lens const& lens, float x, Bounds ys, float p1, float p2, float& most) noexcept
    {
        float const limit = 1.001f * lens.limit, farthest = ys.high > -ys.low ? ys.high : -ys.low, rest = multiply_add(-x, x, limit * limit);
        most = 1e9f;
        if (x > 0 && farthest * farthest > rest) return true;
        if (!(rest > 0)) return false;
        float const widest = std::sqrt(rest);
        ys = {ys.low > -widest ? ys.low : -widest, ys.high < widest ? ys.high : widest};
        if (ys.low > ys.high) return false;
        float const low2 = ys.low * ys.low, high2 = ys.high * ys.high, more = low2 > high2 ? low2 : high2;
        float const less = ys.low < 0 && ys.high > 0 ? 0 : low2 < high2 ? low2 : high2;
        Bounds const g = factor_between(lens, multiply_add(x, x, less), multiply_add(x, x, more));
        float const tilt_low = 2 * p1 * x * ys.low, tilt_high = 2 * p1 * x * ys.high;
        most = x * (x > 0 ? g.high : g.low) + (tilt_low > tilt_high ? tilt_low : tilt_high) + p2 * multiply_add(3 * x, x, p2 > 0 ? more : less);
        most += 2e-6f * (1 + std::fabs(most));
        return true;
    }
    /// Bounds of a lens's factor where the square of the slopes is between s0 and s1.
    static Bounds factor_between(Lens const& lens, float s0, float s1) noexcept
    {
        LensFactor<OneFloat> const first(lens, s0), last(lens, s1);
        if (lens.kind == LensKind::fov) return {last.factor, first.factor}; // atan(q) / q falls
        float const middle = 0.5f * (s0 + s1), half = 0.5f * (s1 - s0);
        auto const series = [&](float const* k) noexcept { // around the middle, by its steepest slope
            float const at = multiply_add(middle, multiply_add(middle, multiply_add(middle, k[2], k[1]), k[0]), 1.0f);
            float const steep = multiply_add(s1, multiply_add(s1, 3 * std::fabs(k[2]), 2 * std::fabs(k[1])), std::fabs(k[0]));
            return Bounds{at - half * steep, at + half * steep};
        };
        Bounds const n = series(lens.k), m = series(lens.k + 3);
        if (!(m.low > 0)) return {0, 1e9f};
        return {n.low / (n.low > 0 ? m.high : m.low), n.high / (n.high > 0 ? m.low : m.high)};
    }
};
} // namespace detail

/// Prepares a Gaussian for exact rays; invisible as in `project`, and where no ray of the picture meets it. Cost: about 600 flops.
inline ExactSplat project_exact(Gaussian const& g, View const& view, TileSize const& tile) noexcept
{
    using namespace detail;
    Camera const& c = view.camera;
    Rules const& m = view.rules;
    ExactSplat out{};
    std::uint32_t const key = depth_key(g, view);
    if (key == 0 || !(g.opacity >= m.alpha_min)) return out;
    for (float const v : g.colour)
        if (!(std::fabs(v) <= largest_colour)) return out;
    for (float const v : g.log_scale)
        if (!(v <= std::numeric_limits<float>::max())) return out;

    // The mean, its distance, and two directions across its ray.
    Float3 const d{g.mean_world[0] - c.position[0], g.mean_world[1] - c.position[1], g.mean_world[2] - c.position[2]};
    auto const in_view = [&](Float3 const& v) noexcept {
        auto const& r = c.rotation;
        return Float3{dot<OneFloat>({r[0][0], r[0][1], r[0][2]}, v), dot<OneFloat>({r[1][0], r[1][1], r[1][2]}, v),
                      dot<OneFloat>({r[2][0], r[2][1], r[2][2]}, v)};
    };
    Float3 const mean = in_view(d);
    float const distance = length<OneFloat>(mean), per_distance = 1 / distance;
    Float3 const ray{mean.x * per_distance, mean.y * per_distance, mean.z * per_distance};
    float const rho = std::sqrt(multiply_add(ray.x, ray.x, ray.y * ray.y)), safe = rho > 0 ? rho : 1;
    float const ex = rho > 0 ? ray.x / safe : 1, ey = rho > 0 ? ray.y / safe : 0;
    Float3 const e1{ray.z * ex, ray.z * ey, -rho}, e2{-ey, ex, 0};

    // Its axes in units of the distance. Beyond 1e9 no real picture shows a difference.
    Float3 axis[3];
    (void)axes_of<OneFloat>(g.rotation, axis);
    ExactFactor f;
    for (int i = 0; i < 3; ++i) {
        float const size = exponential(g.log_scale[i]) * per_distance, scale = size < 1e9f ? size : 1e9f;
        Float3 const a = in_view(axis[i]);
        f.column[i] = {scale * a.x, scale * a.y, scale * a.z};
    }
    // The mean's place in the picture, and the Jacobian there in pixels per unit of its distance, along e1 and e2.
    float at[2], j[2][2];
    auto const jacobian = [&](int k, Float3 const& row) noexcept { j[k][0] = distance * dot(row, e1), j[k][1] = distance * dot(row, e2); };
    if (c.lens.kind == LensKind::pinhole) {
        float const x = mean.x / mean.z, y = mean.y / mean.z;
        at[0] = c.fx * x, at[1] = c.fy * y;
        jacobian(0, {c.fx / mean.z, 0, -(c.fx / mean.z * x)}), jacobian(1, {0, c.fy / mean.z, -(c.fy / mean.z * y)});
    } else if (c.lens.kind == LensKind::equirectangular) {
        float const flat2 = multiply_add(mean.x, mean.x, mean.z * mean.z), least = 1e-6f * distance, exact = std::sqrt(flat2);
        float const flat = exact > least ? exact : least, all = distance * distance; // at a pole, azimuths have no slopes
        float const azimuth = angle_of<OneFloat>(mean.z, std::fabs(mean.x));
        at[0] = c.fx * (mean.x < 0 ? -azimuth : azimuth), at[1] = c.fy * (1.57079633f - angle_of<OneFloat>(mean.y, exact));
        jacobian(0, {c.fx * mean.z / (flat * flat), 0, -(c.fx * mean.x / (flat * flat))});
        jacobian(1, {-(c.fy * mean.x * mean.y / (all * flat)), c.fy * flat / all, -(c.fy * mean.z * mean.y / (all * flat))});
    } else {
        Bent<OneFloat> const bent(c, mean);
        if (!bent.seen) return out;
        at[0] = c.fx * bent.u, at[1] = c.fy * bent.v;
        auto const row = [&](float p, float q) noexcept {
            return Float3{p * bent.across.x + q * bent.down.x, p * bent.across.y + q * bent.down.y, p * bent.across.z + q * bent.down.z};
        };
        jacobian(0, row(bent.mix[0], bent.mix[1])), jacobian(1, row(bent.mix[2], bent.mix[3]));
    }
    // The picture's dilation in space is across the ray: the inverse of the Jacobian.
    float const per = std::sqrt(m.dilation) / (j[0][0] * j[1][1] - j[0][1] * j[1][0]);
    auto const across = [&](float p, float q) noexcept { return Float3{p * e1.x + q * e2.x, p * e1.y + q * e2.y, p * e1.z + q * e2.z}; };
    f.column[3] = across(per * j[1][1], -(per * j[1][0])), f.column[4] = across(-(per * j[0][1]), per * j[0][0]);

    // C = (a b; b c) across the ray by its form LDL^T, and the regression of the depth. `n` is what the second row has beside the first.
    float row1[5], row2[5], along[5], n[5], rest = 0;
    f.times(e1, row1), f.times(e2, row2), f.times(ray, along);
    along[3] = along[4] = 0;
    float const a = dot5(row1, row1);
    if (!(a > 0 && a < 1e30f)) return out;
    float slope = dot5(row1, row2) / a;
    for (int i = 0; i < 5; ++i) n[i] = multiply_add(-slope, row1[i], row2[i]);
    float const again = dot5(row1, n) / a; // roundings of a needle
    slope += again;
    for (int i = 0; i < 5; ++i) n[i] = multiply_add(-again, row1[i], n[i]);
    float const s = dot5(n, n);
    if (!(s > 0 && s < 1e30f)) return out;
    float const by_first = dot5(along, row1) / a, by_second = dot5(along, n) / s;
    for (int i = 0; i < 5; ++i) {
        float const left = multiply_add(-by_second, n[i], multiply_add(-by_first, row1[i], along[i]));
        rest = multiply_add(left, left, rest);
    }

    float opacity = g.opacity < 1 ? g.opacity : 1, shown = g.opacity;
    if (m.coverage == Coverage::preserved) {
        Float3 const minor = cross(Float3{row1[0], row1[1], row1[2]}, Float3{row2[0], row2[1], row2[2]});
        float const kept = dot(minor, minor) / (a * s), least = 0.000025f;
        opacity = shown = opacity * std::sqrt(kept > least ? kept : least);
        if (!(opacity >= m.alpha_min)) return out;
    }
    float const ratio = 2 * logarithm<OneFloat>(shown / m.alpha_min);
    ExactBox const box(f, c, ray, ratio + 1e-4f); // with the roundings of alpha
    if (box.columns == 0 || box.rows == 0) return out;

    bool const by_slopes = !sees_behind(c.lens.kind);
    float const size = by_slopes ? 1 / ray.z : 1, first = 1 / (size * std::sqrt(2 * a)), second = 1 / (size * std::sqrt(2 * s));
    Float3 const off{multiply_add(-slope, e1.x, e2.x), multiply_add(-slope, e1.y, e2.y), multiply_add(-slope, e1.z, e2.z)};
    float const* const rays[] = {&ray.x, &ray.y, &ray.z};
    float const *const ones[] = {&e1.x, &e1.y, &e1.z}, *const offs[] = {&off.x, &off.y, &off.z};
    for (int k = 0; k < 3; ++k) {
        out.towards[k] = *rays[k] * size;
        out.first[k] = first * *ones[k], out.second[k] = second * *offs[k];
        out.depth[k] = (*rays[k] - by_first * *ones[k] - by_second * *offs[k]) / size;
        out.colour[k] = g.colour[k];
    }
    if (by_slopes) out.towards[2] = 1;
    out.spread = 2 * rest;
    if (!(multiply_add(first, first, second * second) < 1e37f && out.spread < 1e37f)) return out;
    out.mean_px[0] = at[0], out.mean_px[1] = at[1];
    out.opacity = opacity, out.depth_key = key;
    out.faintest = m.alpha_min > 1e-36f ? -0.5f * ratio - 0.01f : -std::numeric_limits<float>::infinity();
    std::uint32_t const x = pixel_within(at[0] + c.cx, static_cast<std::uint32_t>(box.columns)) / tile.tile_width;
    std::uint32_t const y = pixel_within(at[1] + c.cy, static_cast<std::uint32_t>(box.rows)) / tile.tile_height;
    out.anchor = TileId{x | y << 16};
    out.columns = static_cast<std::uint32_t>(box.columns), out.rows = static_cast<std::uint32_t>(box.rows);
    return out;
}

}}} // namespace tilemesh::v0_2::splat
TILEMESH_EXACT_END
