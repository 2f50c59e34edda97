#pragma once
#include "support.hpp"
#include <tilemesh/splat/lens_point.hpp>
#include <tilemesh/splat/view.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/rules.hpp>

// A renderer in double that shares no code with the kernels: covariance by matrices, its inverse by the determinant, whole frames without
// rectangles. Derivatives are central differences of it.
namespace support::pose {

using namespace tilemesh;

struct Camera {
    double rotation[3][3], position[3], fx, fy, cx, cy, near_depth, limit_x, limit_y;
    std::uint32_t width, height;
    splat::Camera bent{}; ///< the same camera, with the limit of its lens
};
inline Camera camera_of(splat::Camera const& c, splat::Rules const& m)
{
    Camera d{};
    for (int i = 0; i < 3; ++i) {
        d.position[i] = c.position[i];
        for (int j = 0; j < 3; ++j) d.rotation[i][j] = c.rotation[i][j];
    }
    d.fx = c.fx, d.fy = c.fy, d.cx = c.cx, d.cy = c.cy, d.near_depth = c.near_depth, d.width = c.width, d.height = c.height;
    d.bent = c;
    splat::bound_lens(d.bent);
    d.limit_x = m.jacobian_limit > 0 ? double{m.jacobian_limit} * std::max(d.cx, d.width - d.cx) / c.fx : 1e30;
    d.limit_y = m.jacobian_limit > 0 ? double{m.jacobian_limit} * std::max(d.cy, d.height - d.cy) / c.fy : 1e30;
    return d;
}
/// The camera after motion `column` by `step`: points of view space move by a translation, or turn about the camera centre.
inline Camera moved(Camera c, std::uint32_t column, double step)
{
    if (column < 3) {
        for (int i = 0; i < 3; ++i) c.position[i] -= c.rotation[column][i] * step;
        return c;
    }
    int const axis = int(column) - 3, u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int i = 0; i < 3; ++i) {
        double const a = c.rotation[u][i], b = c.rotation[v][i];
        c.rotation[u][i] = std::cos(step) * a - std::sin(step) * b;
        c.rotation[v][i] = std::sin(step) * a + std::cos(step) * b;
    }
    return c;
}

struct Splat {
    double p[3];             ///< the mean in view space
    double u, v, z;          ///< pixels relative to the principal point
    double a, b, c;          ///< dilated covariance
    double minor, d;         ///< its determinant without dilation and with it; a c - b^2 loses the digits of needles
    double v1[3], v2[3], u3[3];
    double opacity, colour[3];
    splat::GaussianId id;

    double raw_alpha(double x, double y) const
    {
        double const dx = x - u, dy = y - v;
        return opacity * std::exp(-0.5 * (c * dx * dx - 2 * b * dx * dy + a * dy * dy) / d);
    }
};
/// Place and covariance of a Gaussian. False if the camera does not see its mean.
inline bool place(std::array<double, 3> const& mean, std::array<double, 3> const& log_scale, std::array<double, 4> const& q, Camera const& c,
                  splat::Rules const& m, Splat& s)
{
    for (int i = 0; i < 3; ++i) {
        s.p[i] = 0;
        for (std::size_t j = 0; j < 3; ++j) s.p[i] += c.rotation[i][j] * (mean[j] - c.position[j]);
    }
    auto const& p = s.p;
    bool const bends = c.bent.lens.kind != splat::LensKind::pinhole;
    auto const point = splat::through_lens<double>(c.bent, p);
    if (!((bends ? point.depth : p[2]) > c.near_depth) || (bends && !point.seen)) return false;
    double const t = 2 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    double const turn[3][3] = {{1 - t * (q[2] * q[2] + q[3] * q[3]), t * (q[1] * q[2] - q[0] * q[3]), t * (q[1] * q[3] + q[0] * q[2])},
                               {t * (q[1] * q[2] + q[0] * q[3]), 1 - t * (q[1] * q[1] + q[3] * q[3]), t * (q[2] * q[3] - q[0] * q[1])},
                               {t * (q[1] * q[3] - q[0] * q[2]), t * (q[2] * q[3] + q[0] * q[1]), 1 - t * (q[1] * q[1] + q[2] * q[2])}};
    double const sx = p[0] / p[2], sy = p[1] / p[2];
    double const jx = std::clamp(sx, -c.limit_x, c.limit_x), jy = std::clamp(sy, -c.limit_y, c.limit_y);
    double jacobian[2][3] = {{c.fx / p[2], 0, -c.fx / p[2] * jx}, {0, c.fy / p[2], -c.fy / p[2] * jy}};
    for (int i = 0; bends && i < 2; ++i)
        for (int j = 0; j < 3; ++j) jacobian[i][j] = point.by[i][j];
    s.a = s.c = double{m.dilation}, s.b = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        double const scale = std::exp(log_scale[k]);
        double axis[3];
        for (int i = 0; i < 3; ++i) {
            axis[i] = 0;
            for (int j = 0; j < 3; ++j) axis[i] += c.rotation[i][j] * turn[j][k];
            axis[i] *= scale;
        }
        s.v1[k] = s.v2[k] = 0, s.u3[k] = axis[2];
        if (c.bent.lens.kind == splat::LensKind::fisheye) s.u3[k] = (axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2]) / point.depth; // along the ray
        for (int i = 0; i < 3; ++i) s.v1[k] += jacobian[0][i] * axis[i], s.v2[k] += jacobian[1][i] * axis[i];
        s.a += s.v1[k] * s.v1[k], s.b += s.v1[k] * s.v2[k], s.c += s.v2[k] * s.v2[k];
    }
    s.minor = 0;
    for (int i = 0; i < 3; ++i) {
        double const n = s.v1[(i + 1) % 3] * s.v2[(i + 2) % 3] - s.v1[(i + 2) % 3] * s.v2[(i + 1) % 3];
        s.minor += n * n;
    }
    s.d = s.minor + double{m.dilation} * (s.a + s.c - double{m.dilation});
    s.u = bends ? point.at[0] : c.fx * sx, s.v = bends ? point.at[1] : c.fy * sy, s.z = bends ? point.depth : p[2];
    return true;
}
inline bool project(splat::Gaussian const& g, Camera const& c, splat::Rules const& m, Splat& s)
{
    if (!(g.opacity >= m.alpha_min)) return false;
    if (!place({g.mean_world[0], g.mean_world[1], g.mean_world[2]}, {g.log_scale[0], g.log_scale[1], g.log_scale[2]},
               {g.rotation[0], g.rotation[1], g.rotation[2], g.rotation[3]}, c, m, s))
        return false;
    s.opacity = std::min(1.0f, g.opacity), s.id = g.id;
    std::copy_n(g.colour, 3, s.colour);
    return true;
}
/// Colour, transmittance and depth of each pixel. `order`: the Gaussians to blend, front to back.
struct Pixel {
    double colour[3], transmittance, depth;
    double value(std::uint32_t i) const { return i < 3 ? colour[i] : i == 3 ? transmittance : depth; }
    static constexpr std::uint32_t values = 5;
};
inline std::vector<Splat> projected(std::vector<splat::Gaussian> const& order, Camera const& c, splat::Rules const& m)
{
    std::vector<Splat> all;
    Splat s;
    for (auto const& g : order)
        if (project(g, c, m, s)) all.push_back(s);
    return all;
}
/// The Gaussians in front of the near plane, front to back.
inline std::vector<splat::Gaussian> sorted(std::vector<splat::Gaussian> const& gaussians, Camera const& c, splat::Rules const& m)
{
    std::vector<std::pair<double, splat::Gaussian>> seen;
    Splat s;
    for (auto const& g : gaussians)
        if (project(g, c, m, s)) seen.emplace_back(s.z, g);
    std::stable_sort(seen.begin(), seen.end(), [](auto const& a, auto const& b) { return a.first < b.first; });
    std::vector<splat::Gaussian> order;
    for (auto const& one : seen) order.push_back(one.second);
    return order;
}
inline std::vector<Pixel> render(std::vector<Splat> const& splats, Camera const& c, splat::Rules const& m)
{
    std::vector<Pixel> picture;
    for (std::uint32_t y = 0; y < c.height; ++y)
        for (std::uint32_t x = 0; x < c.width; ++x) {
            Pixel p{{0, 0, 0}, 1, 0};
            double depth = 0;
            for (auto const& s : splats) {
                double const alpha = std::min(double{m.alpha_max}, s.raw_alpha(x + 0.5 - c.cx, y + 0.5 - c.cy));
                if (alpha < m.alpha_min || p.transmittance < m.transmittance_min) continue;
                double const w = alpha * p.transmittance;
                for (int i = 0; i < 3; ++i) p.colour[i] += w * s.colour[i];
                depth += w * s.z;
                p.transmittance -= w;
            }
            p.depth = p.transmittance < 1 ? depth / (1 - p.transmittance) : 0;
            picture.push_back(p);
        }
    return picture;
}
using Derivative = std::array<std::vector<Pixel>, 6>;
/// Central differences by each motion: `step` times the median depth for translations, `step` radians for rotations. Depth order and the
/// set of visible Gaussians are those of the camera itself.
inline Derivative central_differences(std::vector<splat::Gaussian> const& order, Camera const& c, splat::Rules const& m, double step)
{
    Derivative d;
    for (std::uint32_t j = 0; j < 6; ++j) {
        auto const up = moved(c, j, step), down = moved(c, j, -step);
        auto const high = render(projected(order, up, m), up, m), low = render(projected(order, down, m), down, m);
        for (std::size_t i = 0; i < high.size(); ++i) {
            Pixel p{};
            for (int k = 0; k < 3; ++k) p.colour[k] = (high[i].colour[k] - low[i].colour[k]) / (2 * step);
            p.transmittance = (high[i].transmittance - low[i].transmittance) / (2 * step);
            p.depth = (high[i].depth - low[i].depth) / (2 * step);
            d[j].push_back(p);
        }
    }
    return d;
}

/// The arithmetic of the kernels' templates, in double.
struct OneDouble {
    using Real = double;
    using Word = std::int64_t;
    using Mask = bool;
    static constexpr std::uint32_t lanes = 1;
    static Real square_root(Real v) noexcept { return std::sqrt(v); }
    static Real all(double v) noexcept { return v; }
    template <class... Masks>
    static Mask every(Masks... m) noexcept
    {
        return (... && m);
    }
    static bool any(Mask m) noexcept { return m; }
    static Real select(Mask m, Real yes, Real no) noexcept { return m ? yes : no; }
    static Real magnitude(Real v) noexcept { return std::fabs(v); }
    static Real multiply_add(Real a, Real b, Real c) noexcept { return a * b + c; }
};

} // namespace support::pose
