#include "catalogue.hpp"
#include "kernel_pixel.hpp"
#include "reference.hpp"
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
using stability::our_splat;
using stability::plain_camera;
using stability::Spread;
using stability::Truth;
using stability::truth;

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

double alpha_of_conic(float xx, float xy, float yy, float opacity, float dx, float dy)
{
    float const power = -0.5f * (xx * dx * dx + yy * dy * dy) - xy * dx * dy;
    return power > 0 ? 0.0 : double{opacity} * std::exp(double{power});
}

Gaussian sample(support::Random& random, float nearest, float farthest, float mean_log_scale, float spread)
{
    auto g = support::ball(1, 0, 0);
    float const z = random.uniform(nearest, farthest);
    g.mean_world[0] = random.uniform(-0.6f, 0.6f) * z, g.mean_world[1] = random.uniform(-0.34f, 0.34f) * z, g.mean_world[2] = z;
    for (float& s : g.log_scale) { // nearly normal
        float sum = 0;
        for (int i = 0; i < 12; ++i) sum += random.uniform(0, 1);
        s = mean_log_scale + spread * (sum - 6);
    }
    for (float& q : g.rotation) q = random.uniform(-1, 1);
    g.opacity = 0.95f;
    return g;
}
/// A pixel within about three standard deviations, in the frame; false if the splat has no such pixel.
bool pixel_near(Truth<double> const& e, Camera const& c, support::Random& random, float& x, float& y)
{
    double const t = random.uniform(0, 3), turn = random.uniform(0, 6.2831853f);
    double const l11 = std::sqrt(e.a), l21 = e.b / l11, l22 = std::sqrt(e.determinant) / l11;
    double const px = e.x + t * l11 * std::cos(turn) + double{c.cx};
    double const py = e.y + t * (l21 * std::cos(turn) + l22 * std::sin(turn)) + double{c.cy};
    if (!(px >= 0 && px < c.width && py >= 0 && py < c.height)) return false;
    x = static_cast<float>(std::floor(px)) + 0.5f - c.cx;
    y = static_cast<float>(std::floor(py)) + 0.5f - c.cy;
    return true;
}
/// Calls f(record, truth, splat, x, y) for n random splats, each with a pixel near it.
template <class F>
void each_sample(std::uint32_t n, std::uint64_t seed, float nearest, float farthest, float mean_log_scale, float spread, F const& f)
{
    support::Random random(seed);
    auto const camera = plain_camera();
    std::uint32_t samples = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
        auto const g = sample(random, nearest, farthest, mean_log_scale, spread);
        auto const e = truth<double>(g, camera, Rules{});
        auto const s = our_splat(g, camera, Rules{});
        float x, y;
        if (!s.visible() || !pixel_near(e, camera, random, x, y)) continue;
        f(g, e, s, x, y);
        ++samples;
    }
    REQUIRE(samples > n / 4);
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
        auto const camera = plain_camera();
        auto const g = support::ball(1, 10, 20, sigma, 0.95f);
        naive += std::isfinite(as_half(sigma * sigma + 0.3f)) ? 0 : 1;
        auto const s = our_splat(g, camera, Rules{});
        REQUIRE(s.visible());
        ours += std::isfinite(s.along) && std::isfinite(s.slope) && std::isfinite(s.across) && s.along < 0 && s.across < 0 ? 0 : 1;
        error = std::max(error, std::fabs(double{alpha_at(s, 300, -100)} - truth<double>(g, camera, Rules{}).alpha_at(300, -100)));
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
    stability::report({65, "s = 1e-4", "s^2 = 0 in half: the axis is lost", "off by " + number(error) + ", relative", "1e-6", true});
}

TEST_CASE("row 66: a mean at pixel 1279.4 keeps its place")
{
    auto camera = plain_camera();
    camera.fx = camera.fy = 1024;
    double naive = 0, ours = 0;
    support::Random random(66);
    for (int i = 0; i < 1000; ++i) {
        float const x = i == 0 ? 1279.4f : random.uniform(1024, 1280);
        auto g = support::ball(1, x - 640, 0);
        g.mean_world[2] = 1024; // one world unit is one pixel
        auto const s = our_splat(g, camera, Rules{});
        double const truth = double{g.mean_world[0]};
        naive = std::max(naive, std::fabs(double{as_half(x)} - double{x}));
        ours = std::max(ours, std::fabs(double{s.mean_px[0]} - truth));
    }
    CHECK(naive > 0.005);
    CHECK(ours <= 0.005);
    stability::report({66, "means at 1024 to 1280 px, 1279.4 among them", number(naive) + " px in half", number(ours) + " px", "0.005 px", true});
}

TEST_CASE("row 67: the stored form of the covariance keeps alpha")
{
    Spread naive, cholesky, ours;
    each_sample(support::fast() ? 4'000 : 40'000, 67, 1, 8, -3.5f, 1,
                [&](Gaussian const& g, Truth<double> const& e, Splat const& s, float x, float y) {
                    double const right = e.alpha_at(double{x}, double{y});
                    float const dx = static_cast<float>(double{x} - e.x), dy = static_cast<float>(double{y} - e.y);
                    auto const half = [](double v) { return as_half(static_cast<float>(v)); };
                    auto const& d = e.determinant;
                    naive.add(std::fabs(alpha_of_conic(half(e.c / d), half(-e.b / d), half(e.a / d), g.opacity, dx, dy) - right), 0);
                    // 1 / sqrt a, b / a, sqrt(a / D).
                    float const l1 = half(1 / std::sqrt(e.a)), k = half(e.b / e.a), l2 = half(std::sqrt(e.a / d));
                    float const p = l1 * dx, q = l2 * (dy - k * dx);
                    cholesky.add(std::fabs(double{g.opacity} * std::exp(-0.5 * double{p * p + q * q}) - right), 0);
                    ours.add(std::fabs(double{alpha_at(s, x, y)} - right), 0);
                });
    CHECK(naive.max_error() > 1e-2);
    CHECK(ours.max_error() <= 1e-2);
    stability::report(
        {67, std::to_string(ours.size()) + " random splats", "conic in half: max " + number(naive.max_error()) + ", p99 " + number(naive.error(0.99)),
         "max " + number(ours.max_error()) + ", p99 " + number(ours.error(0.99)) + " (Cholesky in half: max " + number(cholesky.max_error()) + ")",
         "1e-2", true});
}

TEST_CASE("row 68: the power is not expanded in absolute pixels")
{
    auto const camera = plain_camera();
    Spread naive, ours;
    each_sample(support::fast() ? 4'000 : 40'000, 68, 2, 10, -4, 0.7f,
                [&](Gaussian const& g, Truth<double> const& e, Splat const& s, float x, float y) {
                    double const right = e.alpha_at(double{x}, double{y});
                    // A x^2 + B x y + C y^2 + D x + E y + F, coefficients rounded once.
                    double const xx = e.c / e.determinant, xy = -e.b / e.determinant, yy = e.a / e.determinant;
                    double const mx = e.x + double{camera.cx}, my = e.y + double{camera.cy};
                    auto const f = [](double v) { return static_cast<float>(v); };
                    float const a = f(-0.5 * xx), b = f(-xy), c = f(-0.5 * yy), d = f(xx * mx + xy * my), h = f(yy * my + xy * mx),
                                k = f(-0.5 * (xx * mx * mx + yy * my * my) - xy * mx * my);
                    float const px = x + camera.cx, py = y + camera.cy;
                    float const power = a * px * px + b * px * py + c * py * py + d * px + h * py + k;
                    naive.add(std::fabs(double{g.opacity} * std::min(1.0, std::exp(double{power})) - right), 0);
                    ours.add(std::fabs(double{alpha_at(s, x, y)} - right), 0);
                });
    CHECK(naive.max_error() > 1e-4);
    CHECK(ours.max_error() <= 1e-4);
    stability::report({68, std::to_string(ours.size()) + " random splats",
                       "expanded: median " + number(naive.error(0.5)) + ", max " + number(naive.max_error()),
                       "median " + number(ours.error(0.5)) + ", max " + number(ours.max_error()), "1e-4", true});
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
    stability::report({69, "500 layers of 0.004", number(double{naive}) + " for " + number(truth) + "; alpha of 2.4e-4 is lost",
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
            for (int j = 0; j < 3; ++j) next[i][j] = turn[i][0] * naive[0][j] + turn[i][1] * naive[1][j] + turn[i][2] * naive[2][j];
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
    stability::report(
        {70, "R <- dR R for 1e4, 1e5, 1e6 frames of 0.1 degrees", naive_text + " px", number(ours_off) + " px (absolute poses)", "0.01 px", true});
}
