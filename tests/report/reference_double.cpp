#include "../standard.hpp"
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/rules.hpp>

namespace {

using namespace tilemesh::report;
using tilemesh::splat::Camera, tilemesh::splat::Footprint, tilemesh::splat::Gaussian, tilemesh::splat::GaussianId, tilemesh::splat::Rules;

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
    return {{x, y, z}, {1.0f, 0.5f, 0.25f}, opacity, {1.0f, 0.0f, 0.0f, 0.0f}, {log_scale, log_scale, log_scale}, GaussianId{id}};
}

/// Balls one behind the other on the axis, wider than a pixel, red, green and blue, with these opacities.
std::vector<Gaussian> layers(std::vector<float> const& opacities)
{
    std::vector<Gaussian> all;
    for (std::uint32_t i = 0; i < opacities.size(); ++i) {
        all.push_back(ball(0, 0, 2 + static_cast<float>(i), 0, opacities[i], i + 1));
        for (std::uint32_t k = 0; k < 3; ++k) all.back().colour[k] = k == i ? 1.0f : 0.0f;
    }
    return all;
}
using Rgb = std::vector<double>;
/// The colour at the pixel of plain_camera(32, 32) in whose centre the axis lies, so that alpha is the opacity there.
template <class Cut>
Rgb on_axis(std::vector<Gaussian> const& gaussians, Rules const& rules, Cut const& cuts)
{
    auto const rgb = render_double_unrounded(gaussians, plain_camera(32, 32), rules, cuts);
    auto const* const pixel = &rgb[3 * (13 * 32 + 17)];
    return {pixel, pixel + 3};
}
/// The number of values that differ from those of `whole` in these columns and rows, and from 0 outside.
std::size_t wrong_outside(std::vector<double> const& cut, std::vector<double> const& whole, std::size_t side, std::array<double, 2> columns,
                          std::array<double, 2> rows)
{
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < cut.size(); i += 3) {
        auto const column = static_cast<double>(i / 3 % side), row = static_cast<double>(i / 3 / side);
        bool const inside = columns[0] <= column && column <= columns[1] && rows[0] <= row && row <= rows[1];
        wrong += cut[i] == (inside ? whole[i] : 0.0) ? 0 : 1;
    }
    return wrong;
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
    Camera const turned{{{0.36f, -0.8f, -0.48f}, {0.48f, 0.6f, -0.64f}, {0.8f, 0.0f, 0.6f}}, {-2.0f, 0.25f, -1.5f}, 0, 0, 0, 0, 0, 0, 0};
    std::copy_n(&turned.rotation[0][0], 9, &camera.rotation[0][0]);
    std::copy_n(turned.position, 3, camera.position);
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
std::vector<double> guard_render(std::vector<Gaussian> const& gaussians, Camera const& camera, Rules const& rules,
                                 CutOffs const& cuts = no_cut_offs(0.0))
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
            for (int j = 0; j < 3; ++j) view[i] += Real{camera.rotation[i][j]} * (Real{g.mean_world[j]} - Real{camera.position[j]});
        }
        if (!(view[2] > Real{camera.near_depth})) continue;
        Real const x = view[0] / view[2], y = view[1] / view[2];
        auto const clamped = [&](Real slope, Real centre, Real size, Real focal) {
            Real const limit = Real{rules.jacobian_limit} * std::max(centre, size - centre) / focal;
            return rules.jacobian_limit > 0 ? std::clamp(slope, -limit, limit) : slope;
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
            int const next = (k + 1) % 3, last = (k + 2) % 3;
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
        Real a = 0, b = 0, c = 0, cross = 0;
        for (int k = 0; k < 3; ++k) {
            int const next = (k + 1) % 3;
            Real const area = rows[0][k] * rows[1][next] - rows[0][next] * rows[1][k];
            a += rows[0][k] * rows[0][k];
            b += rows[0][k] * rows[1][k];
            c += rows[1][k] * rows[1][k];
            cross += area * area;
        }
        Real const h = rules.dilation;
        splats.push_back({view[2], Real{camera.fx} * x + Real{camera.cx}, Real{camera.fy} * y + Real{camera.cy}, a + h, b,
                          cross + h * (a + c) + h * h, g.opacity, c + h, &g});
    }
    std::sort(splats.begin(), splats.end(),
              [](Splat const& l, Splat const& r) { return l.z < r.z || (!(r.z < l.z) && l.gaussian->id < r.gaussian->id); });
    // Does no part of a pixel, which is half open, lie in [centre - half, centre + half]?
    auto const outside = [](std::uint32_t pixel, Real centre, Real half) { return pixel + 1 <= centre - half || pixel > centre + half; };
    std::vector<double> picture;
    for (std::uint32_t row = 0; row < camera.height; ++row)
        for (std::uint32_t column = 0; column < camera.width; ++column) {
            Real rgb[3] = {0, 0, 0};
            Real through = 1;
            for (auto const& s : splats) {
                Real const dx = static_cast<Real>(column) + 0.5L - s.u;
                Real const dy = static_cast<Real>(row) + 0.5L - s.v;
                Real const sigmas = cuts.sigmas;
                if (sigmas > 0 && (outside(column, s.u, sigmas * std::sqrt(s.a)) || outside(row, s.v, sigmas * std::sqrt(s.c)))) continue;
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

TEST_CASE("splats are blended front to back, ties by id")
{
    auto const of_two = layers({0.5f, 0.75f});
    auto front = of_two[0], back = of_two[1];
    front.id = GaussianId{7}, back.id = GaussianId{3};
    auto const in_any_order = [&](Rgb const& expected) {
        CHECK(on_axis({front, back}, {}, Cuts::none) == expected);
        CHECK(on_axis({back, front}, {}, Cuts::none) == expected);
    };
    in_any_order({0.5, 0.375, 0.0});
    std::swap(front.mean_world[2], back.mean_world[2]);
    in_any_order({0.125, 0.75, 0.0});
    // Equal depth: the smaller id is in front.
    front.mean_world[2] = back.mean_world[2];
    in_any_order({0.125, 0.75, 0.0});
    std::swap(front.id, back.id);
    in_any_order({0.5, 0.375, 0.0});
}

TEST_CASE("a mean is visible where its depth is greater than near")
{
    auto const seen = [](float z) {
        auto const gaussian = ball(0, 0, z, -3, 1.0f, 1);
        return brightest(render_double_unrounded({&gaussian, 1}, plain_camera(32, 32), {}, Cuts::none));
    };
    for (float const z : {-2.0f, 0.0f, std::nextafter(0.25f, 0.0f), 0.25f}) CHECK(seen(z) == 0.0);
    for (float const z : {std::nextafter(0.25f, 1.0f), 2.0f}) CHECK(seen(z) > 0.5);
}

TEST_CASE("what cannot be projected contributes nothing")
{
    auto const camera = plain_camera(32, 32);
    auto const good = ball(0, 0, 2, -1, 0.5f, 1);
    auto const seen = [](Gaussian const& gaussian, Camera const& by, Rules const& rules = {}) {
        return brightest(render_double_unrounded({&gaussian, 1}, by, rules, Cuts::none));
    };
    constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    std::vector<Gaussian> bad(11, ball(0, 0, 1, -1, 0.5f, 2));
    bad[0].rotation[0] = 0.0f; // no rotation at all
    bad[1].rotation[2] = bad[2].mean_world[0] = bad[3].mean_world[2] = bad[6].log_scale[1] = bad[7].colour[2] = bad[8].opacity = nan;
    bad[4].mean_world[2] = bad[5].log_scale[1] = infinity;
    bad[9].opacity = 0.0f;
    bad[10].mean_world[1] = -infinity;
    for (double const alpha_min : {1e-12, 0.0}) {
        auto const expected = render_double_unrounded({&good, 1}, camera, {}, Cuts::none, 1, alpha_min);
        CHECK(brightest(expected) > 0.4);
        for (std::size_t i = 0; i < bad.size(); ++i) {
            CAPTURE(i);
            CHECK(render_double_unrounded(std::vector{bad[i], good}, camera, {}, Cuts::none, 1, alpha_min) == expected);
        }
    }

    // A camera that is not finite, and one that flattens the world into a line.
    for (float Camera::*const centre : {&Camera::cx, &Camera::cy}) {
        auto broken = camera;
        broken.*centre = nan;
        CHECK(seen(good, broken) == 0.0);
    }
    auto flat = camera;
    flat.fy = flat.fx;
    flat.rotation[1][0] = 1.0f;
    flat.rotation[1][1] = 0.0f;
    auto const unit = ball(0, 0, 2, 0, 0.5f, 1); // all variances are 400, the determinant 0
    Rules sharp;
    sharp.dilation = 0.0f;
    CHECK(seen(unit, flat, sharp) == 0.0);
    CHECK(seen(unit, flat) > 0.4);
    // A line seen without dilation has no area; with dilation it is seen.
    auto line = good;
    line.log_scale[1] = line.log_scale[2] = -infinity;
    CHECK(seen(line, camera, sharp) == 0.0);
    CHECK(seen(line, camera) > 0.4);
    CHECK(seen(good, camera, sharp) > 0.4);
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

TEST_CASE("with cut-offs a term at alpha_min is skipped, and one just above it is not")
{
    Rules const rules;
    auto faint = ball(0, 0, 2, 0, rules.alpha_min, 1);
    auto const seen = [&](Cuts cuts) { return brightest(render_double_unrounded({&faint, 1}, plain_camera(48, 48), rules, cuts)); };
    CHECK(seen(Cuts::same) == 0.0);
    CHECK(seen(Cuts::none) > 0.0039);
    faint.opacity = std::nextafter(rules.alpha_min, 1.0f);
    CHECK(seen(Cuts::same) > 0.0039);
}

TEST_CASE("alpha is at most alpha_max; a pixel stops after the term that crosses transmittance_min, or is finished without it")
{
    auto const three = layers({0.75f, 0.75f, 0.5f}), opaque = layers({1.0f, 1.0f, 0.05f});
    Rgb const none{0.0, 0.0, 0.0}, first{0.75, 0.0, 0.0}, second{0.75, 0.1875, 0.0}, all{0.75, 0.1875, 0.03125};
    auto cuts = no_cut_offs();
    auto const shows = [&](std::vector<Gaussian> const& gaussians, bool blends_crossing, double transmittance_min, Rgb const& expected) {
        CAPTURE(blends_crossing);
        CAPTURE(transmittance_min);
        cuts.blends_crossing = blends_crossing, cuts.transmittance_min = transmittance_min;
        CHECK(on_axis(gaussians, {}, cuts) == expected);
    };
    // The transmittance is 1/4, 1/16, 1/32 behind the three layers. It is 1/2 behind the last layer alone, and 1/8 behind the first and the
    // last: where a crossing term is dropped, the last layer would not cross the limit, and must stay out. "Below" is strict.
    for (auto const& [limit, shown] : {std::pair(0.3, first), {0.25, second}, {0.07, second}, {0.0625, all}, {0.0, all}})
        shows(three, true, limit, shown);
    for (auto const& [limit, shown] : {std::pair(1.0, none), {0.3, none}, {0.25, first}, {0.07, first}, {0.0625, second}, {0.03125, all}, {0.0, all}})
        shows(three, false, limit, shown);
    // An opaque layer that is not clamped is never blended, except if there is no limit.
    shows(opaque, false, 1e-3, none);
    shows(opaque, true, 1e-3, {1.0, 0.0, 0.0});
    shows(opaque, false, 0.0, {1.0, 0.0, 0.0});
    // A term is clamped before the test whether it crosses.
    cuts.alpha_max = 0.5;
    shows(three, false, 0.3, {0.5, 0.0, 0.0});
    cuts.alpha_max = 0.75;
    shows(layers({1.0f, 0.5f}), true, 0.0, {0.75, 0.125, 0.0});
    cuts.alpha_max = 0.99;
    shows(opaque, false, 1e-3, {0.99, 0.0, 0.0}); // 0.0095 would be left behind the third, which is no crossing
    cuts.blends_crossing = true;
    auto const blended = on_axis(opaque, {}, cuts);
    CHECK(blended[0] == 0.99);
    CHECK(std::abs(blended[1] - 0.0099) < 1e-15);
    CHECK(blended[2] == 0.0);
    // A pixel where the second layer is thin enough blends it: each pixel finishes on its own.
    cuts.blends_crossing = false;
    auto const dropped = render_double_unrounded(opaque, plain_camera(32, 32), {}, cuts);
    CHECK(brightest(dropped) == 0.99);
    bool both = false;
    for (std::size_t i = 0; i < dropped.size(); i += 3) both = both || dropped[i + 1] > 0.001;
    CHECK(both);
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
    auto const cut_at = [&](Gaussian const& gaussian, float dilation, double sigmas) {
        Rules rules;
        rules.dilation = dilation;
        auto cuts = no_cut_offs(0.0);
        cuts.sigmas = sigmas;
        return render_double_unrounded({&gaussian, 1}, camera, rules, cuts);
    };
    auto const gaussian = ball(0, 0, 2, 0, 1.0f, 1); // without dilation, the deviations are exactly 20 and 25 pixels
    struct Case {
        double sigmas;
        std::array<double, 2> columns, rows;
    };
    for (auto const& each : {Case{1e-9, {49, 49}, {45, 45}}, Case{0.05, {48, 50}, {44, 46}}, Case{0.5, {39, 59}, {33, 58}},
                             Case{1.0, {29, 69}, {20, 70}}, Case{2.0, {9, 89}, {0, 95}}, Case{3.0, {0, 95}, {0, 95}}}) {
        CAPTURE(each.sigmas);
        CHECK(wrong_outside(cut_at(gaussian, 0, each.sigmas), cut_at(gaussian, 0, 0.0), 96, each.columns, each.rows) == 0);
    }
    // The deviations are those of the dilated covariance: a point has the deviation of the dilation, and is cut 6 pixels away.
    auto const point = ball(0, 0, 2, -20, 1.0f, 1);
    CHECK(wrong_outside(cut_at(point, 9, 2.0), cut_at(point, 9, 0.0), 96, {43, 55}, {39, 51}) == 0);
}

TEST_CASE("of the footprint and the cut in standard deviations the smaller counts")
{
    auto gaussians = random_gaussians(100, 8);
    for (auto& gaussian : gaussians) gaussian.opacity = std::max(gaussian.opacity, 0.01f);
    auto const of = [&](CutOffs cuts, double sigmas) {
        cuts.sigmas = sigmas;
        return render_double_unrounded(gaussians, tilted_camera(64, 48), {}, cuts);
    };
    for (auto const footprint : {Footprint::opacity_box, Footprint::three_sigma_square}) {
        CutOffs const cuts{1e-6, 1.0, 0.0, footprint}; // 5 deviations, so the square is the smaller
        auto const uncut = of(cuts, 0.0);
        // Huge, because the square reaches many deviations of a needle's short axis.
        for (double const none : {1e9, 1e300, std::numeric_limits<double>::infinity()}) CHECK(of(cuts, none) == uncut);
        CHECK(largest_difference(of(cuts, 1.5), uncut) > 0.05);
    }
    CutOffs const box{1.0 / 255.0, 1.0, 0.0, Footprint::opacity_box};
    CHECK(of(box, 3.34) == of(box, 0.0)); // sqrt(2 ln(255)) is 3.33
    // Both footprints hold the box of 3 deviations, where 1e-12 of an opacity is 7 of them.
    CutOffs const square{1e-12, 1.0, 0.0, Footprint::three_sigma_square};
    auto const three = of(square, 3.0);
    CHECK(largest_difference(three, of(square, 0.0)) > 1e-3);
    CHECK(three == of(CutOffs{1e-12, 1.0, 0.0, Footprint::opacity_box}, 3.0));
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
    CHECK(render_double(gaussians, camera, {}, cut_offs(rules), 3).rgb == render_double(gaussians, camera, rules, Cuts::same).rgb);
    CHECK(render_double(gaussians, camera, {}, no_cut_offs()).rgb == render_double(gaussians, camera, rules, Cuts::none).rgb);
}

TEST_CASE("the three-sigma square ends at its columns and rows")
{
    auto const camera = plain_camera(96, 96); // the principal point is (49.5, 45.5)
    Rules square;
    square.footprint = Footprint::three_sigma_square;
    // On the axis the variances on the screen are exact, and the longer one is along `axis`.
    for (std::size_t const axis : {0u, 1u}) {
        CAPTURE(axis);
        auto gaussian = ball(0, 0, 2, -2.0f, 1.0f, 1);
        gaussian.log_scale[axis] = -1.25f;
        auto const cut = render_double_unrounded({&gaussian, 1}, camera, square, Cuts::same);
        auto const box = render_double_unrounded({&gaussian, 1}, camera, {}, Cuts::same);
        double const s = (axis == 0 ? 20.0 : 25.0) * std::exp(-1.25), half = std::ceil(3.0 * std::sqrt(s * s + double{square.dilation}));
        CHECK(wrong_outside(cut, box, 96, {std::floor(49.5 - half), std::floor(49.5 + half)}, {std::floor(45.5 - half), std::floor(45.5 + half)}) ==
              0);
        // The outermost pixels inside the limit are seen, and the opacity box contains the next ones too.
        double const mean = axis == 0 ? 49.5 : 45.5;
        auto const at = [&](double along) {
            return axis == 0 ? 3 * (96 * 45 + static_cast<std::size_t>(along)) : 3 * (96 * static_cast<std::size_t>(along) + 49);
        };
        for (double const end : {mean - half, mean + half}) CHECK(cut[at(end)] > 0.0);
        for (double const beyond : {mean - half - 1, mean + half + 1}) CHECK(box[at(beyond)] > 0.0);
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
    for (std::size_t i = 0; i < whole.size(); i += 3) wrong += box[i] == (whole[i] >= double{rules.alpha_min} ? whole[i] : 0.0) ? 0 : 1;
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

TEST_CASE("the picture agrees with one in long double by other formulas, with and without a limit on the Jacobian's slope")
{
    for (std::uint32_t seed : {11u, 12u}) {
        std::vector<std::vector<double>> seen;
        for (float const limit : {1.3f, 0.0f}) {
            CAPTURE(seed);
            CAPTURE(limit);
            Rules rules;
            rules.jacobian_limit = limit;
            auto const camera = tilted_camera(48, 36);
            auto const gaussians = random_gaussians(80, seed);
            seen.push_back(render_double_unrounded(gaussians, camera, rules, Cuts::none, 1, 0.0));
            CHECK(brightest(seen.back()) > 1.0); // no value is clamped
            CHECK(largest_difference(seen.back(), guard_render(gaussians, camera, rules)) < 1e-12);
        }
        CHECK(largest_difference(seen[0], seen[1]) > 1e-3);
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
        CHECK(std::equal(image.rgb.begin(), image.rgb.end(), rgb.begin(), rgb.end(), [](float v, double d) { return v == static_cast<float>(d); }));
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
