#include "../standard.hpp"
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/rules.hpp>

namespace {

using tilemesh::report::cut_offs;
using tilemesh::report::CutOffs;
using tilemesh::report::Cuts;
using tilemesh::report::no_cut_offs;
using tilemesh::report::render_double;
using tilemesh::report::render_double_unrounded;
using tilemesh::splat::Camera;
using tilemesh::splat::Footprint;
using tilemesh::splat::Gaussian;
using tilemesh::splat::GaussianId;
using tilemesh::splat::Rules;

/// At the origin, looking along z. The principal point is off centre, and the pixels are not square.
Camera plain_camera(std::uint32_t width, std::uint32_t height)
{
    Camera camera{};
    for (int i = 0; i < 3; ++i) camera.rotation[i][i] = 1.0f;
    camera.fx = 40.0f;
    camera.fy = 50.0f;
    camera.cx = static_cast<float>(width) / 2 + 1.5f;
    camera.cy = static_cast<float>(height) / 2 - 2.5f;
    camera.near_depth = 0.25f;
    camera.width = width;
    camera.height = height;
    return camera;
}

Gaussian ball(float x, float y, float z, float log_scale, float opacity, std::uint32_t id)
{
    Gaussian gaussian{};
    gaussian.mean_world[0] = x;
    gaussian.mean_world[1] = y;
    gaussian.mean_world[2] = z;
    gaussian.colour[0] = 1.0f;
    gaussian.colour[1] = 0.5f;
    gaussian.colour[2] = 0.25f;
    gaussian.opacity = opacity;
    gaussian.rotation[0] = 1.0f;
    for (auto& value : gaussian.log_scale) value = log_scale;
    gaussian.id = GaussianId{id};
    return gaussian;
}

Gaussian coloured(Gaussian gaussian, float red, float green, float blue)
{
    gaussian.colour[0] = red;
    gaussian.colour[1] = green;
    gaussian.colour[2] = blue;
    return gaussian;
}

/// Uniform in [low, high), equal with every standard library.
float uniform(std::mt19937& random, double low, double high)
{
    return static_cast<float>(low + (high - low) * static_cast<double>(random()) * 0x1p-32);
}

/// A camera with every degree of freedom in use.
Camera tilted_camera(std::uint32_t width, std::uint32_t height)
{
    auto camera = plain_camera(width, height);
    // Rotation by the unit quaternion (0.8, 0.2, -0.4, 0.4).
    float const rows[3][3] = {{0.36f, -0.8f, -0.48f}, {0.48f, 0.6f, -0.64f}, {0.8f, 0.0f, 0.6f}};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) camera.rotation[i][j] = rows[i][j];
    camera.position[0] = -2.0f;
    camera.position[1] = 0.25f;
    camera.position[2] = -1.5f;
    return camera;
}

/// Balls, discs and needles around the point at depth 2.5 in front of the tilted camera. Some are behind it; some are bright or opaque.
std::vector<Gaussian> random_gaussians(std::uint32_t count, std::uint32_t seed)
{
    std::mt19937 random{seed};
    std::vector<Gaussian> gaussians(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        auto& gaussian = gaussians[i];
        for (auto& value : gaussian.mean_world) value = uniform(random, -1.8, 1.8);
        for (auto& value : gaussian.colour) value = uniform(random, 0.0, 3.8);
        gaussian.opacity = i % 9 == 0 ? 1.0f : uniform(random, 0.0, 1.0);
        for (auto& value : gaussian.rotation) value = uniform(random, -3.0, 3.0);
        for (auto& value : gaussian.log_scale) value = uniform(random, -6.0, -0.7);
        gaussian.id = GaussianId{count - i};
    }
    return gaussians;
}

double largest_difference(std::vector<double> const& a, std::vector<double> const& b)
{
    REQUIRE(a.size() == b.size());
    double largest = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        auto const difference = std::abs(a[i] - b[i]);
        if (!(difference <= largest)) largest = difference; // a NaN stays
        if (std::isnan(largest)) return largest;
    }
    return largest;
}

double brightest(std::vector<double> const& rgb)
{
    return rgb.empty() ? 0.0 : *std::max_element(rgb.begin(), rgb.end());
}

/// Renders the picture a second time, in long double and by other formulas: the screen covariance as V V^T with V = J W R S, the
/// determinant from the cross product of V's rows (only sums of positive terms), the exponent by completing the square, and for every pixel
/// the whole list in depth order until the pixel is finished. It knows all cut-offs except the footprint.
std::vector<double> guard_render(std::vector<Gaussian> const& gaussians, Camera const& camera,
                                 Rules const& rules, CutOffs const& cuts = no_cut_offs(0.0))
{
    using Real = long double;
    struct Splat {
        Real z, u, v, a, b, det, opacity, c;
        Gaussian const* gaussian;
    };
    std::vector<Splat> splats;
    for (auto const& g : gaussians) {
        Real view[3];
        for (int i = 0; i < 3; ++i) {
            view[i] = 0;
            for (int j = 0; j < 3; ++j)
                view[i] += Real{camera.rotation[i][j]} *
                           (Real{g.mean_world[j]} - Real{camera.position[j]});
        }
        if (!(view[2] > Real{camera.near_depth})) continue;
        Real const x = view[0] / view[2];
        Real const y = view[1] / view[2];
        auto const clamped = [&](Real slope, Real centre, Real size, Real focal) {
            Real const limit = Real{rules.jacobian_limit} * std::max(centre, size - centre) / focal;
            return slope > limit ? limit : slope < -limit ? -limit : slope;
        };
        Real const jx = clamped(x, camera.cx, camera.width, camera.fx);
        Real const jy = clamped(y, camera.cy, camera.height, camera.fy);

        // Column k of R S is the local axis k, turned by q e_k q* / |q|^2, times its length.
        Real const w = g.rotation[0];
        Real const q[3] = {g.rotation[1], g.rotation[2], g.rotation[3]};
        Real const norm = w * w + q[0] * q[0] + q[1] * q[1] + q[2] * q[2];
        Real rows[2][3];
        for (int k = 0; k < 3; ++k) {
            // v' = ((w^2 - q.q) v + 2 (q.v) q + 2 w q x v) / |q|^2 with v = e_k.
            Real axis[3];
            int const next = (k + 1) % 3;
            int const last = (k + 2) % 3;
            axis[k] = w * w - (norm - w * w) + 2 * q[k] * q[k];
            axis[next] = 2 * q[k] * q[next] + 2 * w * q[last];
            axis[last] = 2 * q[k] * q[last] - 2 * w * q[next];
            Real local[3];
            for (int i = 0; i < 3; ++i) {
                local[i] = 0;
                for (int j = 0; j < 3; ++j) local[i] += Real{camera.rotation[i][j]} * axis[j];
                local[i] *= std::exp(Real{g.log_scale[k]}) / norm;
            }
            rows[0][k] = Real{camera.fx} / view[2] * (local[0] - jx * local[2]);
            rows[1][k] = Real{camera.fy} / view[2] * (local[1] - jy * local[2]);
        }
        Real a = 0;
        Real b = 0;
        Real c = 0;
        Real cross = 0;
        for (int k = 0; k < 3; ++k) {
            int const next = (k + 1) % 3;
            Real const area = rows[0][k] * rows[1][next] - rows[0][next] * rows[1][k];
            a += rows[0][k] * rows[0][k];
            b += rows[0][k] * rows[1][k];
            c += rows[1][k] * rows[1][k];
            cross += area * area;
        }
        Real const h = rules.dilation;
        splats.push_back({view[2], Real{camera.fx} * x + Real{camera.cx},
                          Real{camera.fy} * y + Real{camera.cy}, a + h, b,
                          cross + h * (a + c) + h * h, g.opacity, c + h, &g});
    }
    std::sort(splats.begin(), splats.end(), [](Splat const& l, Splat const& r) {
        return l.z < r.z || (!(r.z < l.z) && l.gaussian->id < r.gaussian->id);
    });
    // Does no part of a pixel, which is half open, lie in [centre - half, centre + half]?
    auto const outside = [](std::uint32_t pixel, Real centre, Real half) {
        return pixel + 1 <= centre - half || pixel > centre + half;
    };
    std::vector<double> picture;
    for (std::uint32_t row = 0; row < camera.height; ++row)
        for (std::uint32_t column = 0; column < camera.width; ++column) {
            Real rgb[3] = {0, 0, 0};
            Real through = 1;
            for (auto const& s : splats) {
                Real const dx = static_cast<Real>(column) + 0.5L - s.u;
                Real const dy = static_cast<Real>(row) + 0.5L - s.v;
                Real const sigmas = cuts.sigmas;
                if (sigmas > 0 && (outside(column, s.u, sigmas * std::sqrt(s.a)) ||
                                   outside(row, s.v, sigmas * std::sqrt(s.c))))
                    continue;
                Real const e = dy - s.b / s.a * dx;
                Real alpha = s.opacity * std::exp(-(dx * dx / s.a + e * e * s.a / s.det) / 2);
                if (alpha < Real{cuts.alpha_min}) continue;
                if (alpha > Real{cuts.alpha_max}) alpha = cuts.alpha_max;
                bool const crosses = through - through * alpha < Real{cuts.transmittance_min};
                if (crosses && !cuts.blends_crossing) break;
                for (int k = 0; k < 3; ++k) rgb[k] += through * alpha * Real{s.gaussian->colour[k]};
                through -= through * alpha;
                if (crosses) break;
            }
            for (Real value : rgb) picture.push_back(static_cast<double>(value));
        }
    return picture;
}

} // namespace

TEST_SUITE_BEGIN("report");

TEST_CASE("one isotropic Gaussian on the axis is the closed formula")
{
    auto const camera = plain_camera(31, 23);
    auto const gaussian = coloured(ball(0, 0, 2, -1.5f, 0.75f, 1), 3.8f, 1.0f, 0.0f);
    auto const rgb = render_double_unrounded({&gaussian, 1}, camera, {}, Cuts::none, 1, 0.0);
    REQUIRE(rgb.size() == 3 * 31 * 23);
    double const dilation = Rules{}.dilation;
    double const sigma_x = 40.0 / 2.0 * std::exp(-1.5);
    double const sigma_y = 50.0 / 2.0 * std::exp(-1.5);
    double worst = 0.0;
    for (int y = 0; y < 23; ++y)
        for (int x = 0; x < 31; ++x) {
            double const dx = x + 0.5 - 17.0; // cx = 31 / 2 + 1.5
            double const dy = y + 0.5 - 9.0;  // cy = 23 / 2 - 2.5
            double const alpha = 0.75 * std::exp(-0.5 * (dx * dx / (sigma_x * sigma_x + dilation) +
                                                         dy * dy / (sigma_y * sigma_y + dilation)));
            auto const* pixel = &rgb[static_cast<std::size_t>(3 * (31 * y + x))];
            worst = std::max({worst, std::abs(pixel[0] - alpha * double{3.8f}),
                              std::abs(pixel[1] - alpha), std::abs(pixel[2])});
        }
    CHECK(worst < 1e-15);
    CHECK(brightest(rgb) > 2.5); // no value is clamped
}

TEST_CASE("the Jacobian's slope is clamped at the limit times the way to the farther border")
{
    // The farther border is 33.5 of 64 columns away, at a slope of 33.5 / 40; 1.3 of it is 1.089. The mean's slope is 1.5, and it
    // lies at column 40 * 1.5 + cx.
    auto const camera = plain_camera(64, 48);
    auto const gaussian = ball(3, 0, 2, -0.5f, 0.9f, 1);
    double const s = std::exp(-0.5);
    double const mean_x = 60.0 + 33.5;
    double seen[2] = {};
    int run = 0;
    for (float const limit : {1.3f, 0.0f}) {
        CAPTURE(limit);
        Rules rules;
        rules.jacobian_limit = limit;
        auto const rgb = render_double_unrounded({&gaussian, 1}, camera, rules, Cuts::none);
        double const slope = limit > 0.0f ? double{limit} * 33.5 / 40 : 1.5;
        double const xx = 20.0 * s * 20.0 * s * (1.0 + slope * slope) + double{rules.dilation};
        double const yy = 25.0 * s * 25.0 * s + double{rules.dilation};
        double const dx = 63.5 - mean_x;
        double const dy = 20.5 - 21.5;
        double const alpha = double{0.9f} * std::exp(-0.5 * (dx * dx / xx + dy * dy / yy));
        CHECK(alpha > 0.01);
        seen[run] = rgb[3 * (20 * 64 + 63)];
        CHECK(std::abs(seen[run++] - alpha) < 1e-14);
    }
    CHECK(seen[1] > 1.5 * seen[0]);

    // Downwards too: the limit there is 1.3 * (48 - 21.5) / 50 = 0.689.
    auto const below = ball(0, -4, 2, -0.5f, 0.9f, 1);
    auto const rgb = render_double_unrounded({&below, 1}, camera, {}, Cuts::none);
    double const slope = double{1.3f} * 26.5 / 50;
    double const yy = 25.0 * s * 25.0 * s * (1.0 + slope * slope) + double{Rules{}.dilation};
    double const xx = 20.0 * s * 20.0 * s + double{Rules{}.dilation};
    double const dy = 0.5 - (21.5 - 100.0);
    double const dx = 33.5 - 33.5;
    double const alpha = double{0.9f} * std::exp(-0.5 * (dx * dx / xx + dy * dy / yy));
    CHECK(alpha > 1e-8);
    CHECK(std::abs(rgb[3 * 33] - alpha) < 1e-14);
}

TEST_CASE("splats are blended front to back, ties by id")
{
    auto const camera = plain_camera(32, 32);
    auto front = coloured(ball(0, 0, 2, 0, 0.5f, 7), 1, 0, 0);
    auto back = coloured(ball(0, 0, 3, 0, 0.75f, 3), 0, 1, 0);
    // Both means lie on the centre of pixel (17, 13), so that alpha is the opacity there.
    auto const at_centre = [&](std::vector<Gaussian> const& gaussians) {
        auto const rgb = render_double_unrounded(gaussians, camera, {}, Cuts::none);
        auto const* pixel = &rgb[3 * (13 * 32 + 17)];
        return std::vector<double>(pixel, pixel + 3);
    };
    using Rgb = std::vector<double>;
    CHECK(at_centre({front, back}) == Rgb{0.5, 0.375, 0.0});
    CHECK(at_centre({back, front}) == Rgb{0.5, 0.375, 0.0});

    std::swap(front.mean_world[2], back.mean_world[2]);
    CHECK(at_centre({front, back}) == Rgb{0.125, 0.75, 0.0});

    // Equal depth: the smaller id is in front, for any order in the list.
    front.mean_world[2] = back.mean_world[2];
    CHECK(at_centre({front, back}) == Rgb{0.125, 0.75, 0.0});
    CHECK(at_centre({back, front}) == Rgb{0.125, 0.75, 0.0});
    std::swap(front.id, back.id);
    CHECK(at_centre({front, back}) == Rgb{0.5, 0.375, 0.0});
    CHECK(at_centre({back, front}) == Rgb{0.5, 0.375, 0.0});
}

TEST_CASE("a mean is visible where its depth is greater than near")
{
    auto const camera = plain_camera(32, 32);
    auto const seen = [&](float z) {
        auto const gaussian = ball(0, 0, z, -3, 1.0f, 1);
        return brightest(render_double_unrounded({&gaussian, 1}, camera, {}, Cuts::none));
    };
    CHECK(seen(-2.0f) == 0.0);
    CHECK(seen(0.0f) == 0.0);
    CHECK(seen(std::nextafter(0.25f, 0.0f)) == 0.0);
    CHECK(seen(0.25f) == 0.0);
    CHECK(seen(std::nextafter(0.25f, 1.0f)) > 0.5);
    CHECK(seen(2.0f) > 0.5);
}

TEST_CASE("what cannot be projected contributes nothing")
{
    auto const camera = plain_camera(32, 32);
    auto const good = ball(0, 0, 2, -1, 0.5f, 1);
    auto const expected = render_double_unrounded({&good, 1}, camera, {}, Cuts::none);
    CHECK(brightest(expected) > 0.4);
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    constexpr float infinity = std::numeric_limits<float>::infinity();

    std::vector<Gaussian> bad(11, ball(0, 0, 1, -1, 0.5f, 2));
    bad[0].rotation[0] = 0.0f; // no rotation at all
    bad[1].rotation[2] = nan;
    bad[2].mean_world[0] = nan;
    bad[3].mean_world[2] = nan;
    bad[4].mean_world[2] = infinity;
    bad[5].log_scale[1] = infinity;
    bad[6].log_scale[1] = nan;
    bad[7].colour[2] = nan;
    bad[8].opacity = nan;
    bad[9].opacity = 0.0f;
    bad[10].mean_world[1] = -infinity;
    for (std::size_t i = 0; i < bad.size(); ++i) {
        CAPTURE(i);
        std::vector<Gaussian> const both{bad[i], good};
        CHECK(render_double_unrounded(both, camera, {}, Cuts::none) == expected);
        CHECK(render_double_unrounded(both, camera, {}, Cuts::none, 1, 0.0) ==
              render_double_unrounded({&good, 1}, camera, {}, Cuts::none, 1, 0.0));
    }

    // A camera that is not finite, and one that flattens the world into a line.
    for (int axis : {0, 1}) {
        auto broken = camera;
        (axis == 0 ? broken.cx : broken.cy) = nan;
        CHECK(brightest(render_double_unrounded({&good, 1}, broken, {}, Cuts::none)) == 0.0);
    }
    auto flat = camera;
    flat.fy = flat.fx;
    flat.rotation[1][0] = 1.0f;
    flat.rotation[1][1] = 0.0f;
    auto const unit = ball(0, 0, 2, 0, 0.5f, 1); // all variances are 400, the determinant 0
    Rules undilated;
    undilated.dilation = 0.0f;
    CHECK(brightest(render_double_unrounded({&unit, 1}, flat, undilated, Cuts::none)) == 0.0);
    CHECK(brightest(render_double_unrounded({&unit, 1}, flat, {}, Cuts::none)) > 0.4);

    // A line seen without dilation has no area; with dilation it is seen.
    auto line = ball(0, 0, 2, -1, 0.5f, 1);
    line.log_scale[1] = line.log_scale[2] = -infinity;
    Rules sharp;
    sharp.dilation = 0.0f;
    CHECK(brightest(render_double_unrounded({&line, 1}, camera, sharp, Cuts::none)) == 0.0);
    CHECK(brightest(render_double_unrounded({&line, 1}, camera, {}, Cuts::none)) > 0.4);
    CHECK(brightest(render_double_unrounded({&good, 1}, camera, sharp, Cuts::none)) > 0.4);
}

TEST_CASE("a quaternion may have any length")
{
    auto const camera = tilted_camera(32, 24);
    auto gaussians = random_gaussians(20, 4);
    auto const expected = render_double_unrounded(gaussians, camera, {}, Cuts::none);
    CHECK(brightest(expected) > 0.1);
    for (auto& gaussian : gaussians)
        for (auto& value : gaussian.rotation) value *= -0x1p-40f; // exact
    CHECK(render_double_unrounded(gaussians, camera, {}, Cuts::none) == expected);
}

TEST_CASE("with cut-offs a term below alpha_min is skipped")
{
    auto const camera = plain_camera(48, 48);
    auto const gaussian = ball(0, 0, 2, -1, 0.5f, 1);
    Rules const rules;
    auto const whole = render_double_unrounded({&gaussian, 1}, camera, rules, Cuts::none, 1, 0.0);
    auto const cut = render_double_unrounded({&gaussian, 1}, camera, rules, Cuts::same);
    double const alpha_min = double{1.0f / 255.0f};
    std::size_t kept = 0;
    std::size_t skipped = 0;
    double faintest_kept = 1.0;
    double brightest_skipped = 0.0;
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < whole.size(); i += 3) {
        double const alpha = whole[i]; // red is 1
        bool const keep = alpha >= alpha_min;
        wrong += cut[i] == (keep ? alpha : 0.0) ? 0 : 1;
        if (keep) {
            ++kept;
            faintest_kept = std::min(faintest_kept, alpha);
        } else {
            ++skipped;
            brightest_skipped = std::max(brightest_skipped, alpha);
        }
    }
    CHECK(wrong == 0);
    CHECK(kept > 500);
    CHECK(skipped > 400);
    CHECK(faintest_kept < 1.2 * alpha_min); // some pixels lie close to the edge, on both sides
    CHECK(brightest_skipped > 0.8 * alpha_min);

    // At and just above the threshold itself.
    auto faint = ball(0, 0, 2, 0, rules.alpha_min, 1);
    CHECK(brightest(render_double_unrounded({&faint, 1}, camera, rules, Cuts::same)) == 0.0);
    CHECK(brightest(render_double_unrounded({&faint, 1}, camera, rules, Cuts::none)) > 0.0039);
    faint.opacity = std::nextafter(rules.alpha_min, 1.0f);
    CHECK(brightest(render_double_unrounded({&faint, 1}, camera, rules, Cuts::same)) > 0.0039);
}

TEST_CASE("with cut-offs alpha is at most alpha_max")
{
    auto const camera = plain_camera(32, 32);
    Rules rules;
    rules.alpha_max = 0.75f;
    std::vector<Gaussian> const gaussians{coloured(ball(0, 0, 2, 0, 1.0f, 1), 1, 0, 0),
                                          coloured(ball(0, 0, 3, 0, 0.5f, 2), 0, 1, 0)};
    auto const centre = std::size_t{3 * (13 * 32 + 17)};
    auto const cut = render_double_unrounded(gaussians, camera, rules, Cuts::same);
    CHECK(cut[centre] == 0.75);
    CHECK(cut[centre + 1] == 0.125);
    auto const whole = render_double_unrounded(gaussians, camera, rules, Cuts::none);
    CHECK(whole[centre] == 1.0);
    CHECK(whole[centre + 1] == 0.0);
}

TEST_CASE("with cut-offs a pixel stops after the term that crosses transmittance_min")
{
    auto const camera = plain_camera(32, 32);
    auto const centre = std::size_t{3 * (13 * 32 + 17)};
    std::vector<Gaussian> const gaussians{coloured(ball(0, 0, 2, 0, 0.75f, 1), 1, 0, 0),
                                          coloured(ball(0, 0, 3, 0, 0.75f, 2), 0, 1, 0),
                                          coloured(ball(0, 0, 4, 0, 0.5f, 3), 0, 0, 1)};
    // The transmittance is 1/4, 1/16, 1/32 behind the three.
    struct Case {
        float transmittance_min;
        double green, blue;
    };
    for (auto const& each :
         {Case{0.3f, 0.0, 0.0}, Case{0.25f, 0.1875, 0.0}, // "below" is strict
          Case{0.07f, 0.1875, 0.0}, Case{0.0625f, 0.1875, 0.03125}, Case{0.0f, 0.1875, 0.03125}}) {
        CAPTURE(each.transmittance_min);
        Rules rules;
        rules.transmittance_min = each.transmittance_min;
        auto const cut = render_double_unrounded(gaussians, camera, rules, Cuts::same);
        CHECK(cut[centre] == 0.75);
        CHECK(cut[centre + 1] == each.green);
        CHECK(cut[centre + 2] == each.blue);
        auto const whole = render_double_unrounded(gaussians, camera, rules, Cuts::none);
        CHECK(whole[centre + 1] == 0.1875);
        CHECK(whole[centre + 2] == 0.03125);
    }
}

TEST_CASE("where the crossing term is dropped, the pixel is finished without it")
{
    auto const camera = plain_camera(32, 32);
    auto const centre = std::size_t{3 * (13 * 32 + 17)};
    std::vector<Gaussian> const gaussians{coloured(ball(0, 0, 2, 0, 0.75f, 1), 1, 0, 0),
                                          coloured(ball(0, 0, 3, 0, 0.75f, 2), 0, 1, 0),
                                          coloured(ball(0, 0, 4, 0, 0.5f, 3), 0, 0, 1)};
    // The transmittance is 1/4, 1/16, 1/32 behind the three layers. It is 1/2 behind the last layer alone, and 1/8 behind the first and the
    // last. So the last layer would not cross the limit where it must stay out.
    struct Case {
        double transmittance_min, red, green, blue;
    };
    for (auto const& each : {Case{1.0, 0.0, 0.0, 0.0}, Case{0.3, 0.0, 0.0, 0.0},
                             Case{0.25, 0.75, 0.0, 0.0}, // "below" is strict
                             Case{0.07, 0.75, 0.0, 0.0}, Case{0.0625, 0.75, 0.1875, 0.0},
                             Case{0.03125, 0.75, 0.1875, 0.03125}, Case{0.0, 0.75, 0.1875, 0.03125}}) {
        CAPTURE(each.transmittance_min);
        auto cuts = no_cut_offs();
        cuts.transmittance_min = each.transmittance_min;
        cuts.blends_crossing = false;
        auto const cut = render_double_unrounded(gaussians, camera, {}, cuts);
        CHECK(cut[centre] == each.red);
        CHECK(cut[centre + 1] == each.green);
        CHECK(cut[centre + 2] == each.blue);
    }

    // A term is clamped before the test whether it crosses.
    auto clamped = no_cut_offs();
    clamped.alpha_max = 0.5;
    clamped.transmittance_min = 0.3;
    clamped.blends_crossing = false;
    auto const cut = render_double_unrounded(gaussians, camera, {}, clamped);
    CHECK(cut[centre] == 0.5);
    CHECK(cut[centre + 1] == 0.0);
}

TEST_CASE("two layers of 0.99 at a limit of 1e-3, by either rule")
{
    auto const camera = plain_camera(32, 32);
    auto const centre = std::size_t{3 * (13 * 32 + 17)};
    std::vector<Gaussian> const gaussians{coloured(ball(0, 0, 2, 0, 1.0f, 1), 1, 0, 0),
                                          coloured(ball(0, 0, 3, 0, 1.0f, 2), 0, 1, 0),
                                          coloured(ball(0, 0, 4, 0, 0.05f, 3), 0, 0, 1)};
    auto cuts = no_cut_offs();
    cuts.alpha_max = 0.99;
    cuts.transmittance_min = 1e-3;
    auto const blended = render_double_unrounded(gaussians, camera, {}, cuts);
    CHECK(blended[centre] == 0.99);
    CHECK(std::abs(blended[centre + 1] - 0.0099) < 1e-15);
    CHECK(blended[centre + 2] == 0.0);
    cuts.blends_crossing = false;
    auto const dropped = render_double_unrounded(gaussians, camera, {}, cuts);
    CHECK(dropped[centre] == 0.99);
    CHECK(dropped[centre + 1] == 0.0);
    CHECK(dropped[centre + 2] == 0.0); // 0.0095 would be left behind it, which is no crossing

    // A pixel where the second layer is thin enough blends it: each pixel finishes on its own.
    CHECK(brightest(dropped) == 0.99);
    bool both = false;
    for (std::size_t i = 0; i < dropped.size(); i += 3) both = both || dropped[i + 1] > 0.001;
    CHECK(both);

    // Without a clamp an opaque layer is never blended, except if there is no limit.
    cuts.alpha_max = 1.0;
    CHECK(render_double_unrounded(gaussians, camera, {}, cuts)[centre] == 0.0);
    cuts.transmittance_min = 0.0;
    CHECK(render_double_unrounded(gaussians, camera, {}, cuts)[centre] == 1.0);
}

TEST_CASE("with every cut-off it agrees with the picture in long double, pixel by pixel")
{
    auto const camera = tilted_camera(48, 36);
    auto const gaussians = random_gaussians(150, 21);
    std::vector<std::vector<double>> seen;
    for (bool const blends_crossing : {true, false})
        for (double const sigmas : {0.0, 0.7, 2.0, 2.8}) {
            CAPTURE(blends_crossing);
            CAPTURE(sigmas);
            CutOffs const cuts{0.01, 0.97, 0.05, Footprint::opacity_box, sigmas, blends_crossing};
            auto const rgb = render_double_unrounded(gaussians, camera, {}, cuts, 2);
            CHECK(brightest(rgb) > 0.9);
            CHECK(largest_difference(rgb, guard_render(gaussians, camera, {}, cuts)) < 1e-12);
            for (auto const& other : seen) CHECK(largest_difference(rgb, other) > 1e-3);
            seen.push_back(rgb);
        }
}

TEST_CASE("the cut in standard deviations ends at its columns and rows")
{
    auto const camera = plain_camera(96, 96); // the principal point is (49.5, 45.5)
    Rules sharp;
    sharp.dilation = 0.0f; // so that the deviations are exactly 20 and 25 pixels
    auto const gaussian = ball(0, 0, 2, 0, 1.0f, 1);
    auto const whole = render_double_unrounded({&gaussian, 1}, camera, sharp, no_cut_offs(0.0));
    struct Case {
        double sigmas;
        std::size_t first_x, last_x, first_y, last_y;
    };
    for (auto const& each :
         {Case{1e-9, 49, 49, 45, 45}, Case{0.05, 48, 50, 44, 46}, Case{0.5, 39, 59, 33, 58},
          Case{1.0, 29, 69, 20, 70}, Case{2.0, 9, 89, 0, 95}, Case{3.0, 0, 95, 0, 95}}) {
        CAPTURE(each.sigmas);
        auto cuts = no_cut_offs(0.0);
        cuts.sigmas = each.sigmas;
        auto const cut = render_double_unrounded({&gaussian, 1}, camera, sharp, cuts);
        std::size_t wrong = 0;
        for (std::size_t row = 0; row < 96; ++row)
            for (std::size_t column = 0; column < 96; ++column) {
                auto const i = 3 * (96 * row + column);
                bool const inside = each.first_x <= column && column <= each.last_x &&
                                    each.first_y <= row && row <= each.last_y;
                wrong += cut[i] == (inside ? whole[i] : 0.0) ? 0 : 1;
            }
        CHECK(wrong == 0);
    }

    // The deviations are those of the dilated covariance: a point has the deviation of the dilation.
    auto const point = ball(0, 0, 2, -20, 1.0f, 1);
    Rules wide;
    wide.dilation = 9.0f;
    auto cuts = no_cut_offs(0.0);
    cuts.sigmas = 2.0; // 6 pixels
    auto const cut = render_double_unrounded({&point, 1}, camera, wide, cuts);
    CHECK(cut[3 * (96 * 45 + 43)] > 0.1);
    CHECK(cut[3 * (96 * 45 + 42)] == 0.0);
    CHECK(cut[3 * (96 * 51 + 55)] > 0.01);
    CHECK(cut[3 * (96 * 52 + 55)] == 0.0);
}

TEST_CASE("of the footprint and the cut in standard deviations the smaller counts")
{
    auto const camera = tilted_camera(64, 48);
    auto gaussians = random_gaussians(100, 8);
    for (auto& gaussian : gaussians) gaussian.opacity = std::max(gaussian.opacity, 0.01f);
    for (auto const footprint : {Footprint::opacity_box, Footprint::three_sigma_square}) {
        CutOffs cuts{1e-6, 1.0, 0.0, footprint}; // 5 deviations, so the square is the smaller
        auto const uncut = render_double_unrounded(gaussians, camera, {}, cuts);
        // Huge, because the square reaches many deviations of a needle's short axis.
        for (double const none : {0.0, 1e9, 1e300, std::numeric_limits<double>::infinity()}) {
            cuts.sigmas = none;
            CHECK(render_double_unrounded(gaussians, camera, {}, cuts) == uncut);
        }
        cuts.sigmas = 1.5;
        CHECK(largest_difference(render_double_unrounded(gaussians, camera, {}, cuts), uncut) > 0.05);
    }
    CutOffs box{1.0 / 255.0, 1.0, 0.0, Footprint::opacity_box};
    auto const uncut = render_double_unrounded(gaussians, camera, {}, box);
    box.sigmas = 3.34; // sqrt(2 ln(255)) is 3.33
    CHECK(render_double_unrounded(gaussians, camera, {}, box) == uncut);

    // Both footprints hold the box of 3 deviations, where 1e-12 of an opacity is 7 of them.
    CutOffs square{1e-12, 1.0, 0.0, Footprint::three_sigma_square};
    auto const larger = render_double_unrounded(gaussians, camera, {}, square);
    square.sigmas = 3.0;
    auto const three = render_double_unrounded(gaussians, camera, {}, square);
    CHECK(largest_difference(three, larger) > 1e-3);
    CHECK(three == render_double_unrounded(gaussians, camera, {},
                                           CutOffs{1e-12, 1.0, 0.0, Footprint::opacity_box, 3.0}));
}

TEST_CASE("Cuts are two of the cut-offs")
{
    Rules rules;
    rules.alpha_min = 0.02f;
    rules.alpha_max = 0.9f;
    rules.transmittance_min = 0.05f;
    rules.footprint = Footprint::three_sigma_square;
    auto const same = cut_offs(rules);
    CHECK(same.alpha_min == double{0.02f});
    CHECK(same.alpha_max == double{0.9f});
    CHECK(same.transmittance_min == double{0.05f});
    CHECK(same.footprint == Footprint::three_sigma_square);
    CHECK(same.sigmas == 0.0);
    CHECK(same.blends_crossing);
    CHECK(no_cut_offs(-1.0).alpha_min == 0.0);
    CHECK(no_cut_offs(std::numeric_limits<double>::quiet_NaN()).alpha_min == 0.0);

    auto const camera = tilted_camera(64, 48);
    auto const gaussians = random_gaussians(120, 9);
    auto const with_rules = render_double_unrounded(gaussians, camera, rules, Cuts::same);
    auto const without = render_double_unrounded(gaussians, camera, rules, Cuts::none);
    auto const some = render_double_unrounded(gaussians, camera, rules, Cuts::none, 1, 1e-3);
    CHECK(largest_difference(with_rules, without) > 0.01);
    CHECK(largest_difference(some, without) > 1e-5);
    CHECK(render_double_unrounded(gaussians, camera, rules, cut_offs(rules)) == with_rules);
    CHECK(render_double_unrounded(gaussians, camera, rules, no_cut_offs()) == without);
    CHECK(render_double_unrounded(gaussians, camera, rules, no_cut_offs(1e-3)) == some);
    // The given cut-offs count, not the model's.
    CHECK(render_double_unrounded(gaussians, camera, {}, cut_offs(rules)) == with_rules);
    CHECK(render_double(gaussians, camera, {}, cut_offs(rules), 3).rgb ==
          render_double(gaussians, camera, rules, Cuts::same).rgb);
    CHECK(render_double(gaussians, camera, {}, no_cut_offs()).rgb ==
          render_double(gaussians, camera, rules, Cuts::none).rgb);
}

TEST_CASE("the three-sigma square ends at its columns and rows")
{
    auto const camera = plain_camera(96, 96); // the principal point is (49.5, 45.5)
    Rules square;
    square.footprint = Footprint::three_sigma_square;
    // On the axis the variances on the screen are exact, and the longer one is along `axis`.
    for (int axis : {0, 1}) {
        CAPTURE(axis);
        auto gaussian = ball(0, 0, 2, -2.0f, 1.0f, 1);
        gaussian.log_scale[axis] = -1.25f;
        auto const cut = render_double_unrounded({&gaussian, 1}, camera, square, Cuts::same);
        auto const box = render_double_unrounded({&gaussian, 1}, camera, {}, Cuts::same);
        double const s = (axis == 0 ? 20.0 : 25.0) * std::exp(-1.25);
        double const half = std::ceil(3.0 * std::sqrt(s * s + double{square.dilation}));
        std::size_t wrong = 0;
        std::size_t first = 96;
        std::size_t last = 0;
        for (std::size_t row = 0; row < 96; ++row)
            for (std::size_t column = 0; column < 96; ++column) {
                auto const i = 3 * (96 * row + column);
                auto const c = static_cast<double>(column);
                auto const r = static_cast<double>(row);
                bool const inside = std::floor(49.5 - half) <= c && c <= std::floor(49.5 + half) &&
                                    std::floor(45.5 - half) <= r && r <= std::floor(45.5 + half);
                wrong += cut[i] == (inside ? box[i] : 0.0) ? 0 : 1;
                if (cut[i] == 0.0) continue;
                first = std::min(first, axis == 0 ? column : row);
                last = std::max(last, axis == 0 ? column : row);
            }
        CHECK(wrong == 0);
        // The outermost pixels inside the limit, and the next ones, which only the opacity box contains.
        double const mean = axis == 0 ? 49.5 : 45.5;
        CHECK(first == static_cast<std::size_t>(mean - half));
        CHECK(last == static_cast<std::size_t>(mean + half));
        for (auto const beyond : {first - 1, last + 1})
            CHECK(box[axis == 0 ? 3 * (96 * 45 + beyond) : 3 * (96 * beyond + 49)] > 0.0);
    }
}

TEST_CASE("the opacity box loses no term of alpha_min or more")
{
    auto const camera = tilted_camera(64, 48);
    Rules rules;
    rules.transmittance_min = 0.0f;
    Rules square = rules; // its square covers the frame if 3 sigma does
    square.footprint = Footprint::three_sigma_square;
    double more_than_square = 0.0;
    for (auto const& gaussian : random_gaussians(100, 2)) {
        auto const whole = render_double_unrounded({&gaussian, 1}, camera, rules, Cuts::none, 1, 0);
        auto const box = render_double_unrounded({&gaussian, 1}, camera, rules, Cuts::same);
        auto const cut = render_double_unrounded({&gaussian, 1}, camera, square, Cuts::same);
        double const alpha_min = rules.alpha_min;
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < whole.size(); ++i) {
            double const alpha = whole[i] / double{gaussian.colour[i % 3]};
            if (std::abs(alpha - alpha_min) < 1e-12) continue; // both are right
            wrong += box[i] == (alpha > alpha_min ? whole[i] : 0.0) ? 0 : 1;
            more_than_square = std::max(more_than_square, box[i] - cut[i]);
        }
        CHECK(wrong == 0);
    }
    CHECK(more_than_square > 0.004);

    // 490 columns to each side: a box one part in a hundred too small loses four of them.
    auto const wide = plain_camera(1200, 3);
    auto const large = ball(0, 0, 2, 2, 1, 1);
    auto const whole = render_double_unrounded({&large, 1}, wide, rules, Cuts::none, 1, 0);
    auto const box = render_double_unrounded({&large, 1}, wide, rules, Cuts::same);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < whole.size(); i += 3)
        wrong += box[i] == (whole[i] >= double{rules.alpha_min} ? whole[i] : 0.0) ? 0 : 1;
    CHECK(wrong == 0);
    CHECK(box[0] == 0.0);
    CHECK(box[3 * 600] > 0.9);
}

TEST_CASE("terms below 1e-12 do not matter")
{
    for (std::uint32_t seed : {1u, 2u, 3u}) {
        CAPTURE(seed);
        auto const camera = tilted_camera(64, 48);
        auto const gaussians = random_gaussians(200, seed);
        auto const all = render_double_unrounded(gaussians, camera, {}, Cuts::none, 1, 0.0);
        auto const most = render_double_unrounded(gaussians, camera, {}, Cuts::none);
        auto const some = render_double_unrounded(gaussians, camera, {}, Cuts::none, 1, 1e-6);
        CHECK(brightest(all) > 1.0);
        CHECK(all != most); // something was skipped
        CHECK(largest_difference(all, most) < 1e-11);
        CHECK(largest_difference(all, some) > 1e-8); // and the option has an effect
    }
}

TEST_CASE("the picture does not depend on the threads")
{
    auto const gaussians = random_gaussians(120, 7);
    for (auto const cuts : {Cuts::none, Cuts::same}) {
        auto const camera = tilted_camera(37, 29);
        auto const one = render_double_unrounded(gaussians, camera, {}, cuts, 1);
        CHECK(brightest(one) > 0.5);
        for (unsigned threads : {0u, 2u, 3u, 29u, 64u}) {
            CAPTURE(threads);
            CHECK(render_double_unrounded(gaussians, camera, {}, cuts, threads) == one);
        }
    }
    CHECK(render_double(gaussians, plain_camera(5, 1), {}, Cuts::none, 3).rgb.size() == 15);
}

TEST_CASE("the picture agrees with one in long double by other formulas")
{
    for (std::uint32_t seed : {11u, 12u}) {
        CAPTURE(seed);
        auto const camera = tilted_camera(48, 36);
        auto const gaussians = random_gaussians(80, seed);
        auto const rgb = render_double_unrounded(gaussians, camera, {}, Cuts::none, 1, 0.0);
        CHECK(brightest(rgb) > 1.0);
        CHECK(largest_difference(rgb, guard_render(gaussians, camera, {})) < 1e-12);
    }
}

TEST_CASE("the image is the double picture rounded to float")
{
    auto const camera = tilted_camera(20, 16);
    auto const gaussians = random_gaussians(50, 5);
    for (auto const cuts : {Cuts::none, Cuts::same}) {
        auto const rgb = render_double_unrounded(gaussians, camera, {}, cuts, 1, 1e-3);
        auto const image = render_double(gaussians, camera, {}, cuts, 2, 1e-3);
        CHECK(brightest(rgb) > 0.5);
        CHECK(image.width == 20);
        CHECK(image.height == 16);
        REQUIRE(image.rgb.size() == rgb.size());
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < rgb.size(); ++i)
            wrong += image.rgb[i] == static_cast<float>(rgb[i]) ? 0 : 1;
        CHECK(wrong == 0);
    }
}

TEST_CASE("an empty scene is black and an empty frame is empty")
{
    auto const image = render_double({}, plain_camera(3, 2), {}, Cuts::none);
    CHECK(image.rgb == std::vector<float>(18, 0.0f));
    auto const gaussian = ball(0, 0, 2, -1, 0.5f, 1);
    CHECK(render_double({&gaussian, 1}, plain_camera(0, 0), {}, Cuts::none, 4).rgb.empty());
    CHECK(render_double({&gaussian, 1}, plain_camera(0, 9), {}, Cuts::same, 4).rgb.empty());
}

TEST_SUITE_END();
