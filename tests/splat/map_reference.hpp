#pragma once
#include "pose_reference.hpp"
#include <tilemesh/splat/map/chain.hpp>
#include <tilemesh/splat/map/walk.hpp>

// A projection and blending in double, of Gaussians whose parameters are doubles. It shares no code with the kernels. Central differences
// of it are the truth.
namespace support::map {

using namespace tilemesh;
using pose::Camera;

/// Mean, log-scale, quaternion, logit, colour.
using Parameters = std::array<double, splat::map::parameters>;

inline Parameters parameters_of(splat::Gaussian const& g)
{
    double const o = std::clamp(double{g.opacity}, 1e-6, 1 - 1e-6);
    return {g.mean_world[0], g.mean_world[1], g.mean_world[2], g.log_scale[0],        g.log_scale[1], g.log_scale[2], g.rotation[0],
            g.rotation[1],   g.rotation[2],   g.rotation[3],   std::log(o / (1 - o)), g.colour[0],    g.colour[1],    g.colour[2]};
}

using pose::Splat;
inline bool project(Parameters const& g, Camera const& c, splat::Rules const& m, Splat& s)
{
    if (!pose::place({g[0], g[1], g[2]}, {g[3], g[4], g[5]}, {g[6], g[7], g[8], g[9]}, c, m, s)) return false;
    s.opacity = 1 / (1 + std::exp(-g[10]));
    if (m.coverage == splat::Coverage::preserved) s.opacity *= std::sqrt(std::max(double{0.000025f}, s.minor / s.d));
    std::copy_n(g.begin() + 11, 3, s.colour);
    return true;
}

/// The arithmetic of the kernels' templates, in double.
struct OneDouble : pose::OneDouble {
    static Real exponential(Real v) noexcept { return std::exp(v); }
};
using D = OneDouble;

/// A pair of a splat and a pixel, with the decisions that count as constant.
struct Pair {
    std::uint32_t splat;
    bool clamped;
    double alpha;
};
/// A frame with frozen sets: the Gaussians that are seen, front to back, and each pixel's pairs.
struct Frame {
    std::vector<Parameters> gaussians;
    std::vector<Splat> splats;
    std::vector<std::vector<Pair>> pixels;
};
/// The slopes of a linear loss by a pixel's colours, depth sum and last transmittance.
using Linear = std::vector<std::array<double, 5>>;

inline Frame frozen(std::vector<splat::Gaussian> const& gaussians, Camera const& c, splat::Rules const& m)
{
    std::vector<std::pair<double, Parameters>> seen;
    Splat s;
    for (auto const& g : gaussians)
        if (auto const p = parameters_of(g); project(p, c, m, s) && s.opacity >= double{m.alpha_min}) seen.emplace_back(s.z, p);
    std::stable_sort(seen.begin(), seen.end(), [](auto const& a, auto const& b) { return a.first < b.first; });
    Frame f;
    for (auto const& one : seen) {
        f.gaussians.push_back(one.second);
        project(one.second, c, m, s);
        f.splats.push_back(s);
    }
    for (std::uint32_t y = 0; y < c.height; ++y)
        for (std::uint32_t x = 0; x < c.width; ++x) {
            auto& pairs = f.pixels.emplace_back();
            double t = 1;
            for (std::uint32_t i = 0; i < f.splats.size() && t >= double{m.transmittance_min}; ++i) {
                double const raw = f.splats[i].raw_alpha(x + 0.5 - c.cx, y + 0.5 - c.cy), alpha = std::min(raw, double{m.alpha_max});
                if (alpha < double{m.alpha_min}) continue;
                if (m.stop == splat::Stop::before_crossing && t - alpha * t < double{m.transmittance_min}) break;
                pairs.push_back({i, raw > double{m.alpha_max}, alpha});
                t -= alpha * t;
            }
        }
    return f;
}
/// A pixel's linear loss, with splat `moved` in the place of number `i`.
inline double loss_of(Frame const& f, std::size_t pixel, double x, double y, std::array<double, 5> const& slopes, std::uint32_t i,
                      Splat const& moved)
{
    double t = 1, out = 0;
    for (auto const& p : f.pixels[pixel]) {
        Splat const& s = p.splat == i ? moved : f.splats[p.splat];
        double const w = t * (p.splat == i && !p.clamped ? s.raw_alpha(x, y) : p.alpha);
        out += w * (slopes[0] * s.colour[0] + slopes[1] * s.colour[1] + slopes[2] * s.colour[2] + slopes[3] * s.z);
        t -= w;
    }
    return out + slopes[4] * t;
}
/// The sums of each splat by the kernels' template of a pair, in double.
inline std::vector<splat::map::Moments<D>> moments(Frame const& f, Camera const& c, splat::Rules const& m, Linear const& slopes)
{
    std::vector<splat::map::PairSums<D>> sums(f.splats.size());
    for (std::size_t pixel = 0; pixel < f.pixels.size(); ++pixel) {
        double const x = double(pixel % c.width) + 0.5 - c.cx, y = double(pixel / c.width) + 0.5 - c.cy;
        auto const& g = slopes[pixel];
        splat::map::WalkingPixel<D> p{1, loss_of(f, pixel, x, y, g, ~0u, {})};
        for (auto const& pair : f.pixels[pixel]) {
            auto const& s = f.splats[pair.splat];
            double const dx = x - s.u, off = y - s.v - s.b / s.a * dx;
            splat::map::walk_pair<D>(p, pair.alpha, true, !pair.clamped, dx, off, {{s.colour[0], s.colour[1], s.colour[2]}, s.z, 1e30},
                                     {{g[0], g[1], g[2]}, g[3], g[4]},
                                     {m.transmittance_min, 1e30f, splat::map::LastPair::as_cut}, sums[pair.splat]);
        }
    }
    std::vector<splat::map::Moments<D>> out;
    for (std::size_t i = 0; i < sums.size(); ++i) out.push_back(splat::map::in_own_units<D>(sums[i], -0.5 / f.splats[i].a,
        -0.5 * f.splats[i].a / f.splats[i].d));
    return out;
}
inline splat::detail::GaussianWords<D> words_of(Parameters const& p)
{
    return {{p[0], p[1], p[2]}, {p[11], p[12], p[13]}, 1 / (1 + std::exp(-p[10])), {p[6], p[7], p[8], p[9]}, {p[3], p[4], p[5]}};
}

/// Gaussians that are hard to differentiate: needles and discs, close to the near plane, clamped slopes, smaller than the dilation,
/// opaque. The camera is turned, and its lens has two focal lengths.
struct Scene {
    std::vector<splat::Gaussian> gaussians;
    splat::Camera camera;
};
inline Scene stiff_scene(std::uint64_t seed, std::uint32_t width = 48, std::uint32_t height = 32, std::uint32_t n = 40)
{
    Random random(seed * 77 + 5);
    auto const u = [&] { return random.uniform(-1, 1); };
    auto const normal = [&] { return std::sqrt(-2 * std::log(random.uniform(1e-6f, 1))) * std::cos(3.14159265f * u()); };
    Scene out{{}, {}};
    auto& c = out.camera;
    c = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0.3f, -0.2f, 0.1f}, 0.85f * static_cast<float>(width), 1.35f * static_cast<float>(height),
         0.5f * static_cast<float>(width), 0.5f * static_cast<float>(height),
         0.2f, width, height};
    float q[4], squares = 0;
    for (float& v : q) v = normal(), squares += v * v;
    float const t = 2 / squares, w = q[0], x = q[1], y = q[2], z = q[3];
    float const turn[3][3] = {{1 - t * (y * y + z * z), t * (x * y - w * z), t * (x * z + w * y)},
                              {t * (x * y + w * z), 1 - t * (x * x + z * z), t * (y * z - w * x)},
                              {t * (x * z - w * y), t * (y * z + w * x), 1 - t * (x * x + y * y)}};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) c.rotation[i][j] = turn[i][j];
    for (std::uint32_t i = 0; i < n; ++i) {
        splat::Gaussian g{};
        std::uint32_t const kind = i % 5;
        float depth = 1 + 2 * std::fabs(u()), view[3] = {u() * 0.6f * depth, u() * 0.36f * depth, depth};
        float const base = -2.5f + u();
        for (float& s : g.log_scale) s = base + 0.3f * normal();
        if (kind == 0) g.log_scale[i % 3] += 3, g.log_scale[(i + 1) % 3] -= 5;
        if (kind == 1) {
            depth = 0.201f + 0.05f * std::fabs(u());
            view[0] = u() * 0.6f * depth, view[1] = u() * 0.36f * depth, view[2] = depth;
            for (float& s : g.log_scale) s = -3.5f + u();
        }
        if (kind == 2) {
            view[0] = (u() > 0 ? 1.0f : -1.0f) * depth * (0.85f + 0.4f * std::fabs(u()));
            for (float& s : g.log_scale) s = -0.7f + 0.3f * normal();
        }
        if (kind == 3)
            for (float& s : g.log_scale) s = -7 + 2 * u();
        for (int k = 0; k < 3; ++k) {
            g.mean_world[k] = c.position[k];
            for (int j = 0; j < 3; ++j) g.mean_world[k] += c.rotation[j][k] * view[j];
        }
        float const length = std::exp(u());
        for (float& v : g.rotation) v = length * normal();
        g.opacity = 1 / (1 + std::exp(-(kind == 4 ? 4 + 8 * std::fabs(u()) : 2 * u()))); // alpha near 1
        for (float& v : g.colour) v = 0.02f + std::fabs(u());
        g.id = splat::GaussianId{i + 1};
        out.gaussians.push_back(g);
    }
    return out;
}
/// Slopes of all signs.
inline Linear random_slopes(std::size_t pixels, std::uint64_t seed)
{
    Random random(seed + 1000);
    Linear out(pixels);
    for (auto& one : out)
        for (double& v : one) v = random.uniform(-1.5f, 1.5f);
    return out;
}

} // namespace support::map
