#include "catalogue.hpp"
#include "kernel_pixel.hpp"
#include "../splat/support.hpp"
#include <glm/mat3x3.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/splat/compositing.hpp>
#include <tilemesh/splat/projection.hpp>

// Reduced precision and drift: rows 64 to 70 of the catalogue. The library stores 32-bit floats everywhere; the naive form uses half
// precision.
using namespace tilemesh;
using namespace tilemesh::splat;
using stability::number;

namespace {

/// The nearest IEEE half to a float, ties to even, as a float; infinity beyond 65,504.
float as_half(float v)
{
    float const magnitude = std::fabs(v);
    if (!(magnitude < 65520.0f)) return std::copysign(std::isnan(v) ? v : INFINITY, v);
    // Ten bits after the leading one, in steps of at least 2^-24.
    int exponent = 0;
    (void)std::frexp(magnitude, &exponent);
    float const step = std::ldexp(1.0f, std::max(exponent - 11, -24));
    float const halves = magnitude / step;
    float const below = std::floor(halves), rest = halves - below;
    float const rounded = rest > 0.5f || (rest == 0.5f && std::fmod(below, 2.0f) != 0) ? below + 1 : below;
    return std::copysign(rounded * step, v);
}

struct Conic {
    double xx, xy, yy; ///< covariance on the screen, dilated
    double det;
    double x, y; ///< the mean, relative to the principal point
};
/// The projection in double: the factor V = J W R S, and its determinant as a sum of squares.
Conic exact(Gaussian const& g, Camera const& c)
{
    double const q[4] = {g.rotation[0], g.rotation[1], g.rotation[2], g.rotation[3]};
    auto const r = scene::rotation_matrix(q[0], q[1], q[2], q[3]); // columns are the axes
    double view[3] = {};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) view[i] += double{c.rotation[i][j]} * (double{g.mean_world[j]} - double{c.position[j]});
    double const tan_x = 1.3 * std::max(double{c.cx}, c.width - double{c.cx}) / double{c.fx};
    double const tan_y = 1.3 * std::max(double{c.cy}, c.height - double{c.cy}) / double{c.fy};
    double const sx = view[0] / view[2], sy = view[1] / view[2];
    double const jx = std::clamp(sx, -tan_x, tan_x), jy = std::clamp(sy, -tan_y, tan_y);
    double v1[3], v2[3];
    for (int axis = 0; axis < 3; ++axis) {
        double along[3] = {};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) along[i] += double{c.rotation[i][j]} * r[axis][j];
        double const s = std::exp(double{g.log_scale[axis]});
        v1[axis] = double{c.fx} / view[2] * s * (along[0] - jx * along[2]);
        v2[axis] = double{c.fy} / view[2] * s * (along[1] - jy * along[2]);
    }
    double a = 0, b = 0, d = 0, det = 0;
    for (int i = 0; i < 3; ++i) {
        a += v1[i] * v1[i], b += v1[i] * v2[i], d += v2[i] * v2[i];
        double const minor = v1[i] * v2[(i + 1) % 3] - v1[(i + 1) % 3] * v2[i];
        det += minor * minor;
    }
    double const h = double{0.3f};
    return {a + h, b, d + h, det + h * (a + d) + h * h, double{c.fx} * sx, double{c.fy} * sy};
}
double alpha_of(Conic const& e, double opacity, double x, double y)
{
    double const dx = x - e.x, dy = y - e.y, off = dy - e.xy / e.xx * dx;
    return opacity * std::exp(-0.5 * dx * dx / e.xx - 0.5 * off * off * e.xx / e.det);
}
double alpha_of_conic(float xx, float xy, float yy, float opacity, float dx, float dy)
{
    float const power = -0.5f * (xx * dx * dx + yy * dy * dy) - xy * dx * dy;
    return power > 0 ? 0.0 : double{opacity} * std::exp(double{power});
}

Gaussian sample(support::Random& random, float nearest, float farthest, float mean_log_scale, float spread)
{
    auto g = support::ball(1, 0, 0);
    float const z = random.uniform(nearest, farthest);
    g.mean_world[0] = random.uniform(-0.6f, 0.6f) * z, g.mean_world[1] = random.uniform(-0.34f, 0.34f) * z,
    g.mean_world[2] = z;
    for (float& s : g.log_scale) { // nearly normal
        float sum = 0;
        for (int i = 0; i < 12; ++i) sum += random.uniform(0, 1);
        s = mean_log_scale + spread * (sum - 6);
    }
    for (float& q : g.rotation) q = random.uniform(-1, 1);
    g.opacity = 0.95f;
    return g;
}
Camera frame_1280()
{
    auto c = support::flat_camera(1280, 720);
    c.cx = 640, c.cy = 360;
    return c;
}
Splat splat_of(Gaussian const& g, Camera const& c)
{
    return project(g, make_view(c, Rules{}), make_tiling(c.width, c.height, c.width, c.height));
}
/// A pixel within about three standard deviations, in the frame; false if the splat has no such pixel.
bool pixel_near(Conic const& e, Camera const& c, support::Random& random, float& x, float& y)
{
    double const t = random.uniform(0, 3), turn = random.uniform(0, 6.2831853f);
    double const l11 = std::sqrt(e.xx), l21 = e.xy / l11, l22 = std::sqrt(e.det) / l11;
    double const px = e.x + t * l11 * std::cos(turn) + double{c.cx};
    double const py = e.y + t * (l21 * std::cos(turn) + l22 * std::sin(turn)) + double{c.cy};
    if (!(px >= 0 && px < c.width && py >= 0 && py < c.height)) return false;
    x = static_cast<float>(std::floor(px)) + 0.5f - c.cx;
    y = static_cast<float>(std::floor(py)) + 0.5f - c.cy;
    return true;
}
double percentile(std::vector<double>& values, double share)
{
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}
} // namespace

TEST_CASE("the software half rounds as IEEE 754 says")
{
    CHECK(as_half(1.0f) == 1.0f);
    CHECK(as_half(2049.0f) == 2048.0f); // ties to even
    CHECK(as_half(2051.0f) == 2052.0f);
    CHECK(as_half(65519.0f) == 65504.0f);
    CHECK(std::isinf(as_half(65520.0f)));
    CHECK(as_half(0x1p-24f) == 0x1p-24f);
    CHECK(as_half(0x1p-25f) == 0.0f);
    CHECK(as_half(0x1.8p-25f) == 0x1p-24f);
    CHECK(as_half(-0.1f) == -0.0999755859375f);
}

TEST_CASE("row 64: splats of more than 256 pixels stay finite")
{
    std::uint32_t naive = 0, ours = 0;
    double error = 0;
    for (float sigma : {255.0f, 256.0f, 300.0f, 1000.0f, 20'000.0f}) {
        auto const camera = frame_1280();
        auto const g = support::ball(1, 10, 20, sigma, 0.95f);
        naive += std::isfinite(as_half(sigma * sigma + 0.3f)) ? 0 : 1;
        auto const s = splat_of(g, camera);
        REQUIRE(s.visible());
        ours += std::isfinite(s.along) && std::isfinite(s.slope) && std::isfinite(s.across) && s.along < 0 && s.across < 0
                    ? 0
                    : 1;
        error = std::max(error,
                         std::fabs(double{alpha_at(s, 300, -100)} - alpha_of(exact(g, camera), double{0.95f}, 300, -100)));
    }
    CHECK(naive == 4); // all but 255
    CHECK(ours == 0);
    CHECK(error <= 1e-5);
    stability::report({64, "sigma 255 to 20,000 px", std::to_string(naive) + " of 5 half covariances are inf",
                       std::to_string(ours) + " not finite; alpha off by " + number(error), "finite", true});
}

TEST_CASE("row 65: an axis of 1e-4 is kept")
{
    float const size = 1e-4f;
    float const naive = std::sqrt(as_half(size * size));
    float const ours = exponential(std::log(size)); // the record has log scale and quaternion
    double const error = std::fabs(double{ours} / double{size} - 1);
    CHECK(naive == 0.0f);
    CHECK(error <= 1e-6);
    stability::report(
        {65, "s = 1e-4", "s^2 = 0 in half: the axis is lost", "off by " + number(error) + ", relative", "1e-6", true});
}

TEST_CASE("row 66: a mean at pixel 1279.4 keeps its place")
{
    auto camera = frame_1280();
    camera.fx = camera.fy = 1024;
    double naive = 0, ours = 0;
    support::Random random(66);
    for (int i = 0; i < 1000; ++i) {
        float const x = i == 0 ? 1279.4f : random.uniform(1024, 1280);
        auto g = support::ball(1, x - 640, 0);
        g.mean_world[2] = 1024; // one world unit is one pixel
        auto const s = splat_of(g, camera);
        double const truth = double{g.mean_world[0]};
        naive = std::max(naive, std::fabs(double{as_half(x)} - double{x}));
        ours = std::max(ours, std::fabs(double{s.mean_px[0]} - truth));
    }
    CHECK(naive > 0.005);
    CHECK(ours <= 0.005);
    stability::report({66, "means at 1024 to 1280 px, 1279.4 among them", number(naive) + " px in half",
                       number(ours) + " px", "0.005 px", true});
}

TEST_CASE("row 67: the stored form of the covariance keeps alpha")
{
    support::Random random(67);
    auto const camera = frame_1280();
    std::vector<double> naive, cholesky, ours;
    std::uint32_t const n = support::fast() ? 4'000 : 40'000;
    for (std::uint32_t i = 0; i < n; ++i) {
        auto const g = sample(random, 1, 8, -3.5f, 1.0f);
        auto const e = exact(g, camera);
        auto const s = splat_of(g, camera);
        float x, y;
        if (!s.visible() || !pixel_near(e, camera, random, x, y)) continue;
        double const truth = alpha_of(e, double{g.opacity}, double{x}, double{y});
        float const dx = static_cast<float>(double{x} - e.x), dy = static_cast<float>(double{y} - e.y);
        auto const half = [](double v) { return as_half(static_cast<float>(v)); };
        naive.push_back(std::fabs(
            alpha_of_conic(half(e.yy / e.det), half(-e.xy / e.det), half(e.xx / e.det), g.opacity, dx, dy) - truth));
        // 1 / sqrt a, b / a, sqrt(a / D).
        float const l1 = half(1 / std::sqrt(e.xx)), k = half(e.xy / e.xx), l2 = half(std::sqrt(e.xx / e.det));
        float const p = l1 * dx, q = l2 * (dy - k * dx);
        cholesky.push_back(std::fabs(double{g.opacity} * std::exp(-0.5 * double{p * p + q * q}) - truth));
        ours.push_back(std::fabs(double{alpha_at(s, x, y)} - truth));
    }
    REQUIRE(ours.size() > n / 4);
    double const naive_max = percentile(naive, 1), ours_max = percentile(ours, 1);
    CHECK(naive_max > 1e-2);
    CHECK(ours_max <= 1e-2);
    stability::report({67, std::to_string(ours.size()) + " random splats",
                       "conic in half: max " + number(naive_max) + ", p99 " + number(percentile(naive, 0.99)),
                       "max " + number(ours_max) + ", p99 " + number(percentile(ours, 0.99)) + " (Cholesky in half: max " +
                           number(percentile(cholesky, 1)) + ")",
                       "1e-2", true});
}

TEST_CASE("row 68: the power is not expanded in absolute pixels")
{
    support::Random random(68);
    auto const camera = frame_1280();
    std::vector<double> naive, ours;
    std::uint32_t const n = support::fast() ? 4'000 : 40'000;
    for (std::uint32_t i = 0; i < n; ++i) {
        auto const g = sample(random, 2, 10, -4.0f, 0.7f);
        auto const e = exact(g, camera);
        auto const s = splat_of(g, camera);
        float x, y;
        if (!s.visible() || !pixel_near(e, camera, random, x, y)) continue;
        double const truth = alpha_of(e, double{g.opacity}, double{x}, double{y});
        // A x^2 + B x y + C y^2 + D x + E y + F, coefficients rounded once.
        double const xx = e.yy / e.det, xy = -e.xy / e.det, yy = e.xx / e.det;
        double const mx = e.x + double{camera.cx}, my = e.y + double{camera.cy};
        auto const f = [](double v) { return static_cast<float>(v); };
        float const a = f(-0.5 * xx), b = f(-xy), c = f(-0.5 * yy), d = f(xx * mx + xy * my), h = f(yy * my + xy * mx),
                    k = f(-0.5 * (xx * mx * mx + yy * my * my) - xy * mx * my);
        float const px = x + camera.cx, py = y + camera.cy;
        float const power = a * px * px + b * px * py + c * py * py + d * px + h * py + k;
        naive.push_back(std::fabs(double{g.opacity} * std::min(1.0, std::exp(double{power})) - truth));
        ours.push_back(std::fabs(double{alpha_at(s, x, y)} - truth));
    }
    REQUIRE(ours.size() > n / 4);
    double const naive_max = percentile(naive, 1), ours_max = percentile(ours, 1);
    CHECK(naive_max > 1e-4);
    CHECK(ours_max <= 1e-4);
    stability::report({68, std::to_string(ours.size()) + " random splats",
                       "expanded: median " + number(percentile(naive, 0.5)) + ", max " + number(naive_max),
                       "median " + number(percentile(ours, 0.5)) + ", max " + number(ours_max), "1e-4", true});
}

TEST_CASE("row 69: the transmittance is a float")
{
    int const n = 500;
    float const alpha = 0.004f;
    double const truth = std::pow(1 - double{alpha}, n);
    float naive = 1, thin = 1;
    Rules rules;
    stability::KernelPixel pixel{rules};
    for (int i = 0; i < n; ++i) {
        naive = as_half(naive * as_half(1 - alpha));
        thin = as_half(thin * as_half(1 - 2.4e-4f));
        pixel.blend(alpha);
    }
    double const ours = double{pixel.transmittance()};
    CHECK(truth == doctest::Approx(0.1348).epsilon(1e-3));
    CHECK(std::fabs(double{naive} - truth) > 1e-5);
    CHECK(thin == 1.0f); // lost altogether
    CHECK(std::fabs(ours - truth) <= 1e-5);
    stability::report({69, "500 layers of 0.004",
                       number(double{naive}) + " for " + number(truth) + "; alpha of 2.4e-4 is lost",
                       "off by " + number(std::fabs(ours - truth)), "1e-5", true});
}

TEST_CASE("row 70: poses are absolute: a million frames later the picture is where it should be")
{
    // A turn of 0.1 degrees a frame about a tilted axis, and the pixel of a fixed point.
    double const step = 0.1 * 3.14159265358979323846 / 180;
    double const axis[3] = {0.36, 0.8, 0.48};
    auto const turned = [&](double angle) {
        double const s = std::sin(angle / 2);
        return scene::rotation_matrix(std::cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]);
    };
    auto const place = [](glm::dmat3 const& r) {
        // The point that the turned camera sees at (0.3, -0.2, 1), in a frame with a focal length of 1000 px.
        return glm::transpose(r) * glm::dvec3{0.3, -0.2, 1.0};
    };
    auto const lens = scene::lens_from_field_of_view(65.238, {1280, 720});
    auto const pixels_off = [&](float const(&r)[3][3], glm::dvec3 const& p) {
        double v[3] = {};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) v[i] += double{r[i][j]} * p[j];
        return std::hypot(lens.fx * (v[0] / v[2] - 0.3), lens.fy * (v[1] / v[2] + 0.2));
    };

    // R <- dR R in float.
    float naive[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, turn[3][3];
    auto const exact_turn = turned(step);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) turn[i][j] = static_cast<float>(exact_turn[j][i]);
    std::vector<std::uint32_t> marks{10'000, 100'000};
    if (!support::fast()) marks.push_back(1'000'000);
    std::string naive_text;
    double naive_off = 0, ours_off = 0;
    scene::Trajectory trajectory;
    trajectory.push_back({0, {turned(0.7), {1, 2, 3}}});
    for (std::uint32_t frame = 1; frame <= marks.back(); ++frame) {
        float next[3][3];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                next[i][j] = turn[i][0] * naive[0][j] + turn[i][1] * naive[1][j] + turn[i][2] * naive[2][j];
        std::copy(&next[0][0], &next[0][0] + 9, &naive[0][0]);
        if (std::find(marks.begin(), marks.end(), frame) == marks.end()) continue;
        double const angle = step * frame;
        naive_off = pixels_off(naive, place(turned(angle)));
        naive_text += (naive_text.empty() ? "" : ", ") + number(naive_off);
        trajectory.push_back({double(frame), {turned(angle) * turned(0.7), {1, 2, 3}}});
    }
    // The library: the motion since the first pose, with each pose computed on its own.
    auto const path = scene::relative_to_first(trajectory, scene::Pose{});
    for (std::size_t i = 1; i < path.size(); ++i) {
        auto const camera = scene::make_camera(path[i].pose, lens);
        ours_off = std::max(ours_off, pixels_off(camera.rotation, place(turned(step * marks[i - 1]))));
    }
    CHECK(naive_off > 0.01);
    CHECK(ours_off <= 0.01);
    stability::report({70, "R <- dR R for 1e4, 1e5, 1e6 frames of 0.1 degrees", naive_text + " px",
                       number(ours_off) + " px (absolute poses)", "0.01 px", true});
}
