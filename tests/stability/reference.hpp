#pragma once
#include "../splat/support.hpp"
#include "naive_kernel.hpp"
#include <tilemesh/splat/projection.hpp>

// The true alpha, the error that the rounding of its inputs excuses, and the alpha of a kernel.
namespace stability {
using tilemesh::splat::Camera;
using tilemesh::splat::Gaussian;
using tilemesh::splat::Rules;

inline constexpr double u = 0x1p-24;

/// The projection of one Gaussian in T (double, or a wider type to check double), from its float inputs: the factor V = J W R S, with its
/// determinant from the cross product of V's rows. Relative error: that of T times the square root of the covariance's condition number.
template <class T>
struct Truth {
    T depth;
    T x, y; ///< mean, relative to the principal point
    T a, b, c, determinant;
    T opacity;

    /// `dx`, `dy`: from the mean.
    T power_at(T dx, T dy) const
    {
        T const off = dy - b / a * dx;
        return -(dx * dx / a + a / determinant * off * off) / 2;
    }
    /// At (px, py) relative to the principal point.
    T alpha_at(T px, T py) const { return opacity * std::exp(power_at(px - x, py - y)); }
};

/// The rotation of a quaternion of any length except 0.
template <class T>
std::array<std::array<T, 3>, 3> rotation_of(float const (&quaternion)[4])
{
    T q[4], longest = 0;
    for (float v : quaternion) longest = std::max(longest, std::fabs(T(v)));
    for (int i = 0; i < 4; ++i) q[i] = T(quaternion[i]) / longest;
    T const two = 2 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    T const w = q[0], x = q[1], y = q[2], z = q[3];
    return {{{1 - two * (y * y + z * z), two * (x * y - w * z), two * (x * z + w * y)},
             {two * (x * y + w * z), 1 - two * (x * x + z * z), two * (y * z - w * x)},
             {two * (x * z - w * y), two * (y * z + w * x), 1 - two * (x * x + y * y)}}};
}

template <class T>
Truth<T> truth(Gaussian const& g, Camera const& camera, Rules const& rules)
{
    auto const rotation = rotation_of<T>(g.rotation);
    T m[3][3] = {}, t[3] = {};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            t[i] += T(camera.rotation[i][k]) * (T(g.mean_world[k]) - T(camera.position[k]));
            for (int j = 0; j < 3; ++j) m[i][j] += T(camera.rotation[i][k]) * rotation[std::size_t(k)][std::size_t(j)];
        }
    T const slope[2] = {t[0] / t[2], t[1] / t[2]}, f[2] = {T(camera.fx), T(camera.fy)};
    T const size[2] = {T(camera.width), T(camera.height)}, centre[2] = {T(camera.cx), T(camera.cy)};
    T v[2][3];
    for (int r = 0; r < 2; ++r) {
        T bounded = slope[r];
        if (rules.jacobian_limit > 0) {
            bool const trainers = rules.slope_border == tilemesh::splat::SlopeBorder::of_half_width;
            T const limit = T(rules.jacobian_limit) * (trainers ? size[r] / 2 : std::max(centre[r], size[r] - centre[r])) / f[r];
            bounded = std::min(limit, std::max(-limit, bounded));
        }
        for (int j = 0; j < 3; ++j) v[r][j] = f[r] / t[2] * (m[r][j] - bounded * m[2][j]) * std::exp(T(g.log_scale[j]));
    }
    Truth<T> out{t[2], f[0] * slope[0], f[1] * slope[1], 0, 0, 0, 0, std::min(T(g.opacity), T(1))};
    for (int j = 0; j < 3; ++j) {
        int const k = (j + 1) % 3;
        T const area = v[0][j] * v[1][k] - v[0][k] * v[1][j];
        out.a += v[0][j] * v[0][j];
        out.b += v[0][j] * v[1][j];
        out.c += v[1][j] * v[1][j];
        out.determinant += area * area;
    }
    T const h = rules.dilation;
    out.determinant += h * (out.a + out.c) + h * h;
    out.a += h;
    out.c += h;
    return out;
}

/// Moves every float of the Gaussian and of the camera on which alpha depends by one ulp, up or down. The principal point stays: its ulp of
/// 6e-5 pixels would excuse the rounding of an absolute mean, and the kernel's relative mean does not have that rounding.
inline void move_inputs(Gaussian& g, Camera& c, support::Random& random)
{
    std::uint32_t signs = random.bits();
    auto const move = [&signs](float& v) {
        float const end = std::numeric_limits<float>::infinity();
        v = std::nextafter(v, (signs & 1u) != 0 ? end : -end);
        signs >>= 1;
    };
    for (float& v : g.mean_world) move(v);
    for (float& v : g.rotation) move(v);
    for (float& v : g.log_scale) move(v);
    move(g.opacity);
    for (auto& row : c.rotation)
        for (float& v : row) move(v);
    for (float& v : c.position) move(v);
    move(c.fx);
    move(c.fy);
}

/// A Gaussian with pixels of its footprint. For each pixel: alpha, and the change of alpha if the inputs change.
struct Sample {
    static constexpr std::size_t pixels = 6;
    Gaussian g;
    Camera camera;
    std::array<std::uint32_t, pixels> x, y;
    std::array<double, pixels> alpha, moved;
};

/// At the centre of pixel (x, y).
template <class T>
T true_alpha(Truth<T> const& t, Camera const& c, std::uint32_t x, std::uint32_t y)
{
    return t.alpha_at(T(x) + T(0.5) - T(c.cx), T(y) + T(0.5) - T(c.cy));
}

/// Pixels at the mean, within 1 sigma, at 1.5 sigma, at the edge, and two on the ridge where it crosses the frame. Pixels outside the frame
/// are moved to its border. `moved`: the worst of `trials` changes of all inputs at once, with random signs.
inline Sample make_sample(Gaussian const& g, Camera const& camera, Rules const& rules, support::Random& random, int trials = 24)
{
    Sample s{};
    s.g = g;
    s.camera = camera;
    auto const t = truth<double>(g, camera, rules);
    double const mid = (t.a + t.c) / 2, large = mid + std::hypot((t.a - t.c) / 2, t.b), small = t.determinant / large;
    double const angle = 0.5 * std::atan2(2 * t.b, t.a - t.c); // of the long axis
    auto const place = [&](std::size_t i, double px, double py) {
        auto const pixel = [](double v, std::uint32_t size) {
            return static_cast<std::uint32_t>(std::clamp(std::floor(v), 0.0, static_cast<double>(size - 1)));
        };
        s.x[i] = pixel(px + double(camera.cx), camera.width);
        s.y[i] = pixel(py + double(camera.cy), camera.height);
    };
    auto const along_axes = [&](std::size_t i, double major, double minor) {
        double const p = major * std::sqrt(large), q = minor * std::sqrt(small);
        place(i, t.x + p * std::cos(angle) - q * std::sin(angle), t.y + p * std::sin(angle) + q * std::cos(angle));
    };
    auto const uniform = [&random](double low, double high) { return double(random.uniform(float(low), float(high))); };
    double const turn1 = uniform(0, 6.2831), turn2 = uniform(0, 6.2831);
    place(0, t.x, t.y);
    along_axes(1, uniform(-1, 1), uniform(-1, 1));
    along_axes(2, 1.5 * std::cos(turn1), 1.5 * std::sin(turn1));
    along_axes(3, 3.2 * std::cos(turn2), 3.2 * std::sin(turn2));
    // The best row in a random column, the best column in a random row, and up to a sigma beside.
    double const column = uniform(0, camera.width) - double(camera.cx), row = uniform(0, camera.height) - double(camera.cy);
    place(4, column, t.y + t.b / t.a * (column - t.x) + uniform(-1, 1) * std::sqrt(t.determinant / t.a));
    place(5, t.x + t.b / t.c * (row - t.y) + uniform(-1, 1) * std::sqrt(t.determinant / t.c), row);
    for (std::size_t i = 0; i < Sample::pixels; ++i) s.alpha[i] = true_alpha(t, camera, s.x[i], s.y[i]);
    for (int trial = 0; trial < trials; ++trial) {
        Gaussian moved_g = g;
        Camera moved_camera = camera;
        move_inputs(moved_g, moved_camera, random);
        auto const moved = truth<double>(moved_g, moved_camera, rules);
        for (std::size_t i = 0; i < Sample::pixels; ++i)
            s.moved[i] = std::max(s.moved[i], std::fabs(true_alpha(moved, moved_camera, s.x[i], s.y[i]) - s.alpha[i]));
    }
    return s;
}

/// The errors of one kernel over many pixels.
class Spread {
public:
    void add(double error, double moved)
    {
        double const infinity = std::numeric_limits<double>::infinity();
        if (!(error < infinity)) error = infinity; // NaN is the worst error
        double const rho = error / (moved + u);
        rhos_.push_back(rho);
        errors_.push_back(error);
        max_rho_ = std::max(max_rho_, rho);
        max_error_ = std::max(max_error_, error);
    }
    void add(Sample const& s, std::size_t pixel, float alpha) { add(std::fabs(double(alpha) - s.alpha[pixel]), s.moved[pixel]); }

    std::size_t size() const { return rhos_.size(); }
    double max_rho() const { return max_rho_; }
    double max_error() const { return max_error_; }
    double rho(double quantile) const { return at(rhos_, quantile); }
    double error(double quantile) const { return at(errors_, quantile); }

private:
    static double at(std::vector<double> values, double quantile)
    {
        if (values.empty()) return 0;
        auto const n = static_cast<std::ptrdiff_t>(quantile * static_cast<double>(values.size() - 1));
        std::nth_element(values.begin(), values.begin() + n, values.end());
        return values[static_cast<std::size_t>(n)];
    }
    std::vector<double> rhos_, errors_;
    double max_rho_ = 0, max_error_ = 0;
};

/// Alpha of the library at the centre of a pixel: 0 if the splat's rectangle does not contain it.
template <class Record>
tilemesh::splat::Splat our_splat(Record const& g, Camera const& c, Rules const& rules)
{
    using namespace tilemesh::splat;
    return project(g, make_view(c, rules), make_tiling(c.width, c.height, c.width, c.height));
}
inline float our_alpha(tilemesh::splat::Splat const& s, Camera const& c, std::uint32_t x, std::uint32_t y)
{
    auto const r = s.rect();
    if (!s.visible() || x < r.x0 || x >= r.x1 || y < r.y0 || y >= r.y1) return 0.0f;
    return tilemesh::splat::alpha_at(s, static_cast<float>(x) + 0.5f - c.cx, static_cast<float>(y) + 0.5f - c.cy);
}

/// The default model with a footprint that contains every pixel worth measuring, so that only rounding is measured.
inline Rules uncut()
{
    Rules m;
    m.alpha_min = 1e-12f;
    return m;
}

/// Identity pose, f about 1000, 1280 x 720.
inline Camera plain_camera()
{
    Camera c = support::flat_camera(1280, 720);
    c.cx = 640, c.cy = 360;
    return c;
}

/// A quaternion of random direction, not normalised.
inline void random_rotation(Gaussian& g, support::Random& random)
{
    float length;
    do {
        length = 0;
        for (float& q : g.rotation) {
            q = random.uniform(-1.02f, 1.02f);
            length += q * q;
        }
    } while (!(length > 0.185f)); // norms 0.43 to 2.04
}

} // namespace stability
