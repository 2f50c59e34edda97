// test: cost 5
#include "support.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/report/enclosure.hpp>
#include <tilemesh/report/exact_rays.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/scene/lens.hpp>
#include <tilemesh/scene/near_plane.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/splat/bend.hpp>
#include <tilemesh/splat/lens_point.hpp>
#include <tilemesh/splat/project_all.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
using support::Random;

namespace {
struct Named {
    char const* name;
    Lens lens;
};
/// TUM's fr1 and EuRoC's cam0 (the calibrations that come with these data sets), a rational lens, TUM-VI's FOV, and a fisheye.
std::array<Named, 5> lenses()
{
    return {{{"fr1", {LensKind::opencv, {0.2624f, -0.9531f, 1.1633f, 0, 0, 0}, {-0.0054f, 0.0026f}, 0, 0}},
             {"euroc", {LensKind::opencv, {-0.28340811f, 0.07395907f, 0, 0, 0, 0}, {0.00019359f, 1.76187114e-5f}, 0, 0}},
             {"rational", {LensKind::opencv, {0.3f, -0.1f, 0.02f, 0.35f, -0.05f, 0.01f}, {0.001f, -0.002f}, 0, 0}},
             {"fov", {LensKind::fov, {0.93f}, {}, 0, 0}},
             {"fisheye", {LensKind::fisheye, {-0.02f, 0.01f, -0.002f, 0.0003f}, {}, 0, 0}}}};
}
/// A camera with this lens: 64 degrees to a side, or a fisheye of 200.
Camera through(Lens const& lens, std::uint32_t width = 640, std::uint32_t height = 480, float turn = 0)
{
    auto c = support::lens(width, height, turn);
    auto const w = static_cast<float>(width);
    c.fx = lens.kind == LensKind::fisheye ? 0.28f * w : 0.8f * w, c.fy = 1.01f * c.fx;
    c.cx = 0.503f * w, c.cy = 0.502f * static_cast<float>(height);
    c.lens = lens;
    return c;
}
/// A hand that turns fast: a radian a second or more, while 640 x 480 are read in 30 ms.
constexpr Shutter fast_hand{{0.015f, 0.05f, -0.01f}, {0.02f, -0.01f, 0.03f}, 0};
/// Points on all sides, some behind the camera.
template <class T>
std::array<T, 3> any_point(Random& random)
{
    return {static_cast<T>(random.uniform(-3, 3)), static_cast<T>(random.uniform(-3, 3)), static_cast<T>(random.uniform(-1, 4))};
}
using tests::error_of, tests::has;
std::string fault(Camera const& c)
{
    return error_of([&] { scene::check_camera(c); });
}
std::vector<Gaussian> around(std::uint32_t n, std::uint64_t seed)
{
    auto all = support::cloud(n, seed);
    Random random(seed + 1);
    for (auto& g : all)
        if (random.below(3) == 0) {
            auto const p = any_point<float>(random);
            for (std::size_t i = 0; i < 3; ++i) g.mean_world[i] = p[i];
        }
    return all;
}
} // namespace

TEST_CASE("the angle of a vector: within 3 ulp of atan2, at all octants and ends")
{
    Random random(1);
    double worst = 0;
    for (int i = 0; i < 200'000; ++i) {
        float const size = std::exp(random.uniform(-30, 30)), along = size * random.uniform(-1, 1), across = size * random.uniform(0, 1);
        double const expected = std::atan2(double{across}, double{along});
        float const angle = splat::detail::angle_of<splat::detail::OneFloat>(along, across);
        double const ulp = std::ldexp(1.0, std::max(-149, std::ilogb(std::max(expected, 1e-37)) - 23));
        worst = std::max(worst, std::fabs(double{angle} - expected) / ulp);
    }
    CHECK(worst < 3); // 2.6
    CHECK(worst > 0.5);
    using splat::detail::angle_of;
    using splat::detail::OneFloat;
    CHECK(angle_of<OneFloat>(0, 0) == 0);
    CHECK(angle_of<OneFloat>(1, 0) == 0);
    CHECK(angle_of<OneFloat>(0, 1) == doctest::Approx(1.5707963));
    CHECK(angle_of<OneFloat>(-1, 0) == doctest::Approx(3.1415927));
}

TEST_CASE("a point through a lens: the Jacobian is that of differences, and the ray of its pixel points back at it")
{
    for (auto const& [name, lens] : lenses()) {
        INFO(name);
        auto const camera = make_view(through(lens), {}).camera;
        Random random(2);
        double worst_slope = 0, worst_ray = 0;
        std::uint32_t seen = 0, behind = 0, beyond = 0;
        for (int i = 0; i < 4000; ++i) {
            auto const at = any_point<double>(random);
            double const p[3] = {at[0], at[1], at[2]};
            auto const here = through_lens<double>(camera, p);
            if (!here.seen) continue;
            ++seen, behind += p[2] < 0 ? 1 : 0;
            bool const linear = lens.kind != LensKind::fisheye && std::hypot(p[0], p[1]) > 0.999 * camera.lens.limit * p[2];
            double largest = 0, error = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                double const h = 1e-6;
                double above[3] = {p[0], p[1], p[2]}, below[3] = {p[0], p[1], p[2]};
                above[k] += h, below[k] -= h;
                auto const a = through_lens<double>(camera, above), b = through_lens<double>(camera, below);
                if (!a.seen || !b.seen) continue;
                for (std::size_t j = 0; j < 2; ++j) {
                    largest = std::max(largest, std::fabs(here.by[j][k]));
                    error = std::max(error, std::fabs(here.by[j][k] - (a.at[j] - b.at[j]) / (2 * h)));
                }
            }
            if (linear) { // the Jacobian there is that of the nearest direction within the limit
                ++beyond;
                continue;
            }
            worst_slope = std::max(worst_slope, error / largest);
            double ray[3];
            REQUIRE(ray_of<double>(camera, here.at[0], here.at[1], ray));
            double const size = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]), length = std::sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2]);
            for (std::size_t k = 0; k < 3; ++k) worst_ray = std::max(worst_ray, std::fabs(p[k] / size - ray[k] / length));
        }
        CHECK(seen > 1000);
        CHECK(worst_slope < 3e-8); // 2e-9; differences of doubles
        CHECK(worst_ray < 1e-13);
        if (lens.kind == LensKind::fisheye) CHECK(behind > 300);
        else CHECK(beyond > 300);
    }
}

TEST_CASE("project through a lens: the reference in double, every number of lanes, and a pinhole's bits; also by a rolling shutter")
{
    std::vector<std::pair<Named, Shutter>> all_lenses{{{"pinhole", {}}, fast_hand}};
    for (auto const& each : lenses()) all_lenses.insert(all_lenses.end(), {{each, {}}, {each, fast_hand}});
    for (auto const& [named, shutter] : all_lenses) {
        auto const& lens = named.lens;
        INFO(named.name, shutter.rolls() ? ", rolling" : "");
        auto camera = through(lens);
        camera.shutter = shutter;
        auto const view = make_view(camera, {});
        auto const tiling = make_tiling(camera.width, camera.height, 32, 20);
        auto const all = around(4096, 3);
        std::vector<Splat> one;
        std::uint32_t visible = 0, behind = 0, wrong = 0;
        double worst_px = 0, worst_variance = 0;
        for (auto const& g : all) {
            auto const s = one.emplace_back(project(g, view, tiling));
            CHECK(s.depth_key == (s.visible() ? depth_key(g, view) : 0u));
            if (!s.visible()) continue;
            ++visible, behind += g.mean_world[2] < 0 ? 1 : 0;
            auto const expected = report::detail::project_reference(g, camera, {}, report::CutOffs{});
            REQUIRE(expected);
            CHECK(s.depth() == doctest::Approx(expected->depth).epsilon(1e-6));
            double const x = double{s.mean_px[0]} + camera.cx - expected->mean_x, y = double{s.mean_px[1]} + camera.cy - expected->mean_y;
            double const far = 1 + 1e-3 * (std::fabs(expected->mean_x) + std::fabs(expected->mean_y)); // means far outside have larger coordinates
            worst_px = std::max(worst_px, std::max(std::fabs(x), std::fabs(y)) / far);
            double const variance = 1 / (expected->conic_xx - expected->conic_xy * expected->conic_xy / expected->conic_yy);
            worst_variance = std::max(worst_variance, std::fabs(-0.5 / double{s.along} / variance - 1));
        }
        CHECK(visible > 1000);
        CHECK(worst_px < 1e-3);
        CHECK(worst_variance < 1e-4);
        if (lens.kind == LensKind::fisheye) CHECK(behind > 100);
        auto const in_lanes = [&](auto lanes) {
            std::vector<Splat> out(all.size());
            project_all<decltype(lanes)::value>(all.data(), static_cast<std::uint32_t>(all.size()), view, tiling, out.data());
            for (std::size_t i = 0; i < all.size(); ++i) wrong += std::memcmp(&out[i], &one[i], sizeof(Splat)) != 0 ? 1 : 0;
        };
        in_lanes(std::integral_constant<std::uint32_t, 4>{});
        in_lanes(std::integral_constant<std::uint32_t, 8>{});
        in_lanes(std::integral_constant<std::uint32_t, 16>{});
        in_lanes(std::integral_constant<std::uint32_t, splat::detail::lanes_in_use>{});
        CHECK(wrong == 0);

        // With nothing bent, a program for any lens has the bits of one for pinholes.
        auto straight = view;
        straight.camera.lens = {}, straight.camera.shutter = {};
        for (auto const& g : all) {
            auto const a = project<Pinhole>(g, straight, tiling), b = project<AnyLens>(g, straight, tiling);
            wrong += std::memcmp(&a, &b, sizeof a) != 0 ? 1 : 0;
        }
        CHECK(wrong == 0);
    }
}

TEST_CASE("a rolling shutter: a mean is where a search over the rows finds it, and its conic has the slopes of differences")
{
    for (auto const& lens : {Lens{}, lenses()[0].lens, lenses()[4].lens}) {
        auto camera = through(lens);
        camera.shutter = fast_hand;
        Rules rules;
        rules.dilation = 0, rules.jacobian_limit = 0;
        auto const view = make_view(camera, rules);
        auto const tiling = make_tiling(camera.width, camera.height, 32, 20);
        // Where the camera of the row sees a point that is seen on that row: no fixed point, but 60 halvings.
        auto const seen_at = [&](std::array<double, 3> const& p) {
            double const from[3] = {p[0], p[1], p[2]};
            double low = -view.camera.shutter.reach, high = view.camera.shutter.reach, at[3];
            auto const beyond = [&](double v) {
                RowPose<double>(view.camera.shutter, v).seen(from, at);
                return through_lens<double>(view.camera, at).at[1] / view.camera.fy - v;
            };
            for (int i = 0; i < 60; ++i) (beyond((low + high) / 2) > 0 ? low : high) = (low + high) / 2;
            (void)beyond(low);
            auto const point = through_lens<double>(view.camera, at);
            return std::array{point.at[0], point.at[1]};
        };
        Random random(11);
        double worst_px = 0, worst_slope = 0;
        std::uint32_t count = 0;
        for (int i = 0; i < 2000; ++i) {
            Gaussian g = support::cloud(1, 1)[0];
            double const z = random.uniform(1, 5);
            std::array<double, 3> const p{z * random.uniform(-0.5f, 0.5f), z * random.uniform(-0.4f, 0.4f), z};
            for (std::size_t k = 0; k < 3; ++k) {
                double world = view.camera.position[k];
                for (std::size_t j = 0; j < 3; ++j) world += view.camera.rotation[j][k] * p[j];
                g.mean_world[k] = static_cast<float>(world), g.log_scale[k] = -5.0f;
            }
            g.opacity = 0.9f;
            auto const s = project(g, view, tiling);
            auto const exact = seen_at(p);
            if (!s.visible() || std::fabs(exact[1] / view.camera.fy) > 0.9 * view.camera.shutter.reach) continue;
            ++count;
            worst_px = std::max({worst_px, std::fabs(s.mean_px[0] - exact[0]), std::fabs(s.mean_px[1] - exact[1])});
            double j[2][3], c[3] = {0, 0, 0};
            for (std::size_t k = 0; k < 3; ++k) {
                auto less = p, more = p;
                less[k] -= 1e-5, more[k] += 1e-5;
                auto const a = seen_at(less), b = seen_at(more);
                for (std::size_t r = 0; r < 2; ++r) j[r][k] = (b[r] - a[r]) / 2e-5;
                c[0] += j[0][k] * j[0][k], c[1] += j[0][k] * j[1][k], c[2] += j[1][k] * j[1][k];
            }
            double const scale = std::exp(-10.0), a = -0.5 / double{s.along}, b = s.slope * a, cc = -0.5 / double{s.across} + b * b / a;
            double const size = scale * std::max(c[0], c[2]);
            worst_slope = std::max({worst_slope, std::fabs(a - scale * c[0]) / size, std::fabs(b - scale * c[1]) / size, std::fabs(cc - scale * c[2]) / size});
        }
        CHECK(count > 1000);
        CHECK(worst_px < 3e-3);
        CHECK(worst_slope < 5e-5);
        MESSAGE("largest errors: ", worst_px, " px, ", worst_slope, " of the covariance");
    }
}

TEST_CASE("a rolling shutter from poses: the first and the last row have them; a steady path; bad motions are one line")
{
    auto camera = through(lenses()[0].lens);
    auto const lens = scene::lens_of(camera);
    scene::Pose const first{scene::rotation_matrix(0.9, 0.1, 0.3, -0.2), {1, 2, 3}};
    scene::Pose const last{scene::rotation_matrix(0.999, 0.02, -0.03, 0.01) * first.rotation, {1.02, 1.99, 3.05}};
    auto const rolling = scene::rolling_camera(first, last, lens);
    auto const at = scene::pose_of(rolling);
    for (auto const& [pose, y] : {std::pair{first, 0.0}, std::pair{last, 480.0}}) {
        RowPose<double> const row(rolling.shutter, (y - camera.cy) / camera.fy);
        glm::dvec3 const p{4, -1, 5}, expected = pose.rotation * (p - pose.position), in_view = at.rotation * (p - at.position);
        double const from[3] = {in_view.x, in_view.y, in_view.z};
        double to[3];
        row.seen(from, to);
        for (int k = 0; k < 3; ++k) CHECK(to[k] == doctest::Approx(expected[k]).epsilon(1e-6));
    }
    scene::Trajectory path;
    for (int i = 0; i < 4; ++i) path.push_back({0.1 * i, {scene::rotation_matrix(1, 0, 0.01 * i, 0), {0.02 * i, 0, 0}}});
    auto const steady = scene::shutter_at(path, 2, 0.03, lens), at_end = scene::shutter_at(path, 3, 0.03, lens);
    CHECK(steady.turn[1] == doctest::Approx(-0.2 * 0.03 * lens.fy / 480).epsilon(1e-3)); // 0.02 rad in 0.1 s, and 480 rows in 0.03 s
    CHECK(at_end.turn[1] == doctest::Approx(steady.turn[1]).epsilon(1e-3));
    CHECK(std::hypot(steady.move[0], steady.move[2]) == doctest::Approx(0.2 * 0.03 * lens.fy / 480).epsilon(1e-3));
    path[3].seconds = path[1].seconds;
    CHECK(has(error_of([&] { (void)scene::shutter_at(path, 2, 0.03, lens); }), "the rolling shutter of pose 3 (the time stamps around it do not rise"));
    path.resize(1);
    CHECK(has(error_of([&] { (void)scene::shutter_at(path, 0, 0.03, lens); }), "do not rise"));

    camera.shutter = {{0, 3, 0}, {}, 0};
    CHECK(has(fault(camera), "it turns by more than 1 radian, or by no number, while half of its rows are read"));
    camera.shutter = {{0, 0, 0}, {0, NAN, 0}, 0};
    CHECK(has(fault(camera), "its shutter moves by a length that is not a number"));
    // What moves down as fast as the rows are read is not drawn: the camera turns up by 0.9 radians a focal length of rows.
    auto const all = support::cloud(50, 6);
    camera.shutter = {{0.9f, 0, 0}, {}, 0};
    camera.cy = 240, camera.height = 480;
    auto const view = make_view(camera, {});
    auto const tiling = make_tiling(640, 480, 32, 20);
    std::uint32_t drawn = 0;
    for (auto const& g : all) {
        auto const s = project(g, view, tiling);
        drawn += s.visible() ? 1 : 0;
        CHECK(std::isfinite(s.mean_px[0] + s.along + s.across));
    }
    camera.shutter.turn[0] = -0.9f;
    auto const other = make_view(camera, {});
    std::uint32_t drawn_back = 0;
    for (auto const& g : all) drawn_back += project(g, other, tiling).visible() ? 1 : 0;
    CHECK(std::min(drawn, drawn_back) == 0);
    CHECK(std::max(drawn, drawn_back) > 10);
}

TEST_CASE("a lens of OpenCV whose coefficients are 0 draws what a pinhole draws, up to the bound of the slopes")
{
    auto camera = support::lens(640, 480);
    Rules rules;
    rules.jacobian_limit = 0;
    auto const pinhole = make_view(camera, rules);
    camera.lens.kind = LensKind::opencv;
    camera.lens.limit = 1e3f; // as without a bound
    auto const bent = make_view(camera, rules);
    auto const tiling = make_tiling(640, 480, 32, 20);
    std::uint32_t visible = 0;
    for (auto const& g : support::cloud(2000, 4)) {
        auto const a = project(g, pinhole, tiling), b = project(g, bent, tiling);
        REQUIRE(a.visible() == b.visible());
        if (!a.visible()) continue;
        ++visible;
        CHECK(a.mean_px[0] == doctest::Approx(b.mean_px[0]).epsilon(1e-6));
        CHECK(a.along == doctest::Approx(b.along).epsilon(1e-5));
        CHECK(a.across == doctest::Approx(b.across).epsilon(1e-5));
        CHECK(a.depth_key == b.depth_key);
    }
    CHECK(visible > 1000);
}

TEST_CASE("the mesh shows the picture of a lens and of a rolling shutter: both programs, tile sizes, threads, windows, the picture in double")
{
    for (auto const& [name, lens] : lenses()) {
        INFO(name);
        auto const all = around(support::fast() ? 200 : 500, 5);
        auto const camera = through(lens, 96, 60);
        Camera const next = [&] {
            auto rolling = through(lens, 96, 60, 0.1f);
            rolling.shutter = fast_hand;
            return rolling;
        }();
        Rules const rules; // `precise`, as a naive picture is
        auto const expected = report::render_naive(all, camera, rules), after = report::render_naive(all, next, rules);
        for (auto const program : {splat::Program::anchored, splat::Program::homes})
            for (std::uint32_t const side : {1u, 4u}) {
                RendererOptions options{.threads = side == 1 ? 1u : 2u, .grid = {side, side}};
                auto setup = splat::lossless;
                setup.machine.sram_bytes = 1u << 24;
                setup.sizes.tile_pixels = 96 * 60;
                setup.rules = rules;
                if (program == splat::Program::homes) setup = splat::as_homes(setup);
                Renderer renderer(support::map_of(all), setup, options);
                for (auto const& [view, picture] : {std::pair{&camera, &expected}, std::pair{&next, &after}, std::pair{&camera, &expected}})
                    CHECK(support::differing_pixels(renderer.render(*view).image, *picture) == 0);
            }
        auto const window = window_of(next, {17, 80, 9, 51});
        auto const part = report::render_naive(all, window, bounds_of(next, rules));
        std::uint32_t wrong = 0;
        auto const in_double = report::render_double_unrounded(std::span<Gaussian const>(all), camera, rules, report::Cuts::same);
        for (std::uint32_t y = 0; y < 42; ++y)
            for (std::uint32_t x = 0; x < 3 * 63; ++x) wrong += part.rgb[3 * 63 * y + x] != after.rgb[3 * (96 * (y + 9) + 17) + x] ? 1 : 0;
        CHECK(wrong == 0);
        std::vector<double> errors;
        for (std::size_t i = 0; i < expected.rgb.size(); ++i) errors.push_back(std::fabs(double{expected.rgb[i]} - in_double[i]));
        std::sort(errors.begin(), errors.end());
        CHECK(errors[errors.size() * 99 / 100] < 1e-4); // a cut-off may differ in a pixel
        CHECK(std::count_if(in_double.begin(), in_double.end(), [](double v) { return v > 0.05; }) > 1000);
    }
}

TEST_CASE("no record is NaN or infinite in a picture through a lens, and lanes have the bits of one float")
{
    Random random(12);
    std::uint32_t visible = 0, wrong = 0, broken = 0;
    for (auto const& [name, lens] : lenses()) {
        auto camera = through(lens, 64, 40);
        for (float const dilation : {0.3f, 0.0f}) {
            Rules rules;
            rules.dilation = dilation;
            auto const view = make_view(camera, rules);
            auto const tiling = make_tiling(64, 40, 16, 10);
            auto all = around(2048, 13);
            for (auto& g : all) support::spoil(g, random, 6);
            std::vector<Splat> lanes(all.size());
            project_all(all.data(), static_cast<std::uint32_t>(all.size()), view, tiling, lanes.data());
            for (std::size_t i = 0; i < all.size(); ++i) {
                auto const s = project(all[i], view, tiling);
                wrong += std::memcmp(&s, &lanes[i], sizeof s) != 0 ? 1 : 0;
                if (!s.visible()) continue;
                ++visible;
                bool sound = s.depth_key != 0 && std::isfinite(s.depth()) && s.across < 0; // minus infinity: a needle of no width, undilated
                for (float const v : {s.mean_px[0], s.mean_px[1], s.along, s.slope, s.opacity}) sound = sound && std::isfinite(v);
                broken += sound ? 0 : 1;
            }
            for (float const v : report::render_naive(all, camera, rules).rgb) broken += std::isfinite(v) ? 0 : 1;
        }
    }
    CHECK(visible > 500);
    CHECK(wrong == 0);
    CHECK(broken == 0);
}

TEST_CASE("the slopes of a pixel are found through every lens of slopes that is not refused")
{
    Random random(11);
    std::uint32_t lenses_seen = 0, refused = 0, pixels = 0;
    double worst = 0;
    for (int i = 0; i < (support::fast() ? 400 : 4000); ++i) {
        auto camera = support::lens(640, 480);
        camera.fx = camera.fy = random.uniform(250, 900);
        if (random.below(3) == 0) {
            camera.lens = {LensKind::fov, {random.uniform(0.1f, 3)}, {}, 0, 0};
        } else {
            camera.lens.kind = LensKind::opencv;
            for (std::size_t k = 0; k < (random.below(2) == 0 ? 3u : 6u); ++k) camera.lens.k[k] = random.uniform(-0.5f, 0.5f);
            for (float& p : camera.lens.p) p = random.below(2) == 0 ? 0 : random.uniform(-0.01f, 0.01f);
        }
        if (!fault(camera).empty()) {
            ++refused;
            continue;
        }
        ++lenses_seen;
        auto const bounded = make_view(camera, {}).camera;
        for (int k = 0; k < 30; ++k) {
            float const across = random.uniform(0, 640) - camera.cx, down = random.uniform(0, 480) - camera.cy;
            double ray[3];
            if (!ray_of<double>(bounded, double{across}, double{down}, ray)) continue; // a dark corner
            ++pixels;
            using A = splat::detail::OneFloat;
            float x = 0, y = 0;
            splat::detail::unbend<A>(bounded.lens, across / camera.fx, down / camera.fy, x, y);
            splat::detail::BentSlopes<A> const at(bounded.lens, x, y);
            worst = std::max(worst, std::hypot(double{at.u * camera.fx - across}, double{at.v * camera.fy - down}));
        }
    }
    MESSAGE(lenses_seen << " lenses, " << refused << " refused, " << pixels << " pixels, worst " << worst << " px");
    CHECK(lenses_seen > 50);
    CHECK(refused > 50);
    CHECK(worst < 0.05);
}

TEST_CASE("a lens as a text: what is written is read, another text is refused by name; the focal length of an angle")
{
    for (char const* text : {"pinhole", "opencv,0.25,-0.125,0,0,0.5", "opencv,0.25", "fisheye", "fisheye,0,0,0,0.125", "fov,0.875"})
        CHECK(scene::text_of(scene::lens_of_text(text)) == text);
    CHECK(scene::text_of(scene::lens_of_text("opencv,0.1,0.2,0.3,0.4,0.5,0.6,0.7,0.8")) ==
          "opencv,0.100000001,0.200000003,0.300000012,0.400000006,0.5,0.600000024,0.699999988,0.800000012");
    auto const fault = [](char const* text) { return error_of([&] { scene::lens_of_text(text); }); };
    CHECK(fault("fish") == "the lens \"fish\" (there is no such lens); write opencv,k1,k2,p1,p2,k3,k4,k5,k6 or fisheye,k1,k2,k3,k4 or fov,omega or equirectangular; "
                           "numbers at the end may be left out");
    CHECK(has(fault(""), "there is no such lens"));
    CHECK(has(fault("fov,1,2"), "it has at most 1 numbers"));
    CHECK(has(fault("pinhole,1"), "it has at most 0 numbers"));
    CHECK(has(fault("opencv,a"), "a coefficient is no number"));
    CHECK(has(fault("opencv,,1"), "a coefficient is no number"));
    CHECK(scene::focal_of({}, 90, 640) == doctest::Approx(320));
    CHECK(scene::focal_of({LensKind::fisheye, {}, {}, 0, 0}, 180, 640) == doctest::Approx(320 / 1.5707963));
    CHECK(has(error_of([] { scene::focal_of({}, 180, 640); }), "a field of view of 180 degrees through the lens pinhole"));
    CHECK(has(error_of([] { scene::focal_of(scene::lens_of_text("opencv,-0.3"), 120, 640); }), "it does not see that far"));
}

TEST_CASE("a folding lens: beyond 0.95 of its fold nothing is drawn, pixels without a ray keep the background, and readers say where it folds")
{
    Camera camera = through({LensKind::opencv, {-0.28340811f, 0, 0, 0, 0, 0}, {}, 0, 0});
    camera.fx = camera.fy = 585; // the picture's corner is at 0.9 of the slopes, the fold at 1.08
    auto const fold = reach_of<double>(camera.lens, 10.0);
    CHECK(fold.is_fold);
    CHECK(fold.fold == doctest::Approx(std::sqrt(1 / (3 * 0.28340811))));
    auto const view = make_view(camera, {});
    CHECK(view.camera.lens.ends == 1);
    CHECK(view.camera.lens.limit == doctest::Approx(0.95 * fold.fold));
    auto const at = [&](float slope) {
        auto g = support::ball(1, 0, 0, 0.01f);
        g.mean_world[0] = 2 * slope, g.mean_world[1] = 0, g.mean_world[2] = 2;
        g.log_scale[0] = g.log_scale[1] = g.log_scale[2] = 0; // so that it reaches into the picture
        return project(g, view, {640, 480});
    };
    auto const limit = view.camera.lens.limit;
    CHECK(at(0.999f * limit).depth_key != 0);
    CHECK(at(1.001f * limit).depth_key == 0);
    CHECK(at(3).depth_key == 0);
    double ray[3];
    CHECK(ray_of<double>(view.camera, 0.5 * camera.fx, 0, ray));
    CHECK_FALSE(ray_of<double>(view.camera, 0.8 * camera.fx, 0, ray)); // beyond the largest radius, 0.72

    CHECK(fault(camera) == "");
    camera.fx = camera.fy = 512; // the corner has no ray
    CHECK(fault(camera) == "a camera that no frame can be rendered with (its lens folds within the picture, at a slope of 1.084509); correct the camera");
}

TEST_CASE("a fisheye sees behind itself: depth and near plane are distances; lenses that there are not are refused")
{
    auto camera = through({LensKind::fisheye, {}, {}, 0, 0});
    camera.near_depth = 0.5f;
    auto const view = make_view(camera, {});
    auto const at = [&](float x, float z) {
        auto g = support::ball(1, 0, 0, 0.01f);
        g.mean_world[0] = x, g.mean_world[1] = 0, g.mean_world[2] = z;
        return project(g, view, {640, 480});
    };
    CHECK(at(1, -0.2f).visible()); // 101 degrees from the axis
    CHECK(at(1, -0.2f).depth() == doctest::Approx(std::hypot(1, 0.2)));
    CHECK(at(1, -0.2f).mean_px[0] == doctest::Approx(static_cast<double>(camera.fx) * std::atan2(1.0, -0.2)));
    CHECK(at(0.6f, 0).visible());
    CHECK_FALSE(at(0.4f, 0).visible()); // nearer than the near plane
    CHECK_FALSE(at(0, -2).visible());
    CHECK(fault(camera) == "");
    camera.fx = camera.fy = 70;
    CHECK(fault(camera) == "a camera that no frame can be rendered with (its lens sees more than 360 degrees: the picture's nearest side is beyond "
                           "an angle of 3.138451 radians); correct the camera");
    camera.fx = camera.fy = 180;
    for (float const v : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 2e6f}) {
        camera.lens.k[2] = v;
        CHECK(has(fault(camera), "a coefficient of its lens is not a number within 1e6"));
    }
    camera.lens = {LensKind::fov, {0}, {}, 0, 0};
    CHECK(has(fault(camera), "omega of its lens is not between 0 and 3 radians"));
    camera.lens.kind = static_cast<LensKind>(9);
    CHECK(has(fault(camera), "a kind of lens that there is not"));
}

TEST_CASE("exact rays: the largest response along a ray, found by a search; the conic of the Jacobian approaches them")
{
    for (auto const& [name, lens] : {Named{"pinhole", {}}, lenses()[0], lenses()[4]}) {
        INFO(name);
        auto const camera = through(lens, 32, 24);
        auto const bounded = make_view(camera, {}).camera;
        Rules rules;
        rules.dilation = 0;
        Gaussian g = support::cloud(1, 9)[0];
        g.mean_world[0] = 0.2f, g.mean_world[1] = -0.1f, g.mean_world[2] = 1.2f;
        g.log_scale[0] = -1.2f, g.log_scale[1] = -2, g.log_scale[2] = -1.6f;
        g.opacity = 0.9f;
        std::vector<Gaussian> const one{g};
        auto const picture = report::render_exact_rays(one, camera, rules);
        auto const r = report::detail::rotation_of(g.rotation);
        auto const inverse = [&](std::array<double, 3> const& v) { // of the covariance, applied to v on both sides: v^T R S^-2 R^T v
            double squared = 0;
            for (std::size_t k = 0; k < 3; ++k)
                squared += std::pow(r[0][k] * v[0] + r[1][k] * v[1] + r[2][k] * v[2], 2) * std::exp(-2 * double{g.log_scale[k]});
            return squared;
        };
        double worst = 0, most = 0;
        for (std::uint32_t y = 0; y < camera.height; y += 3)
            for (std::uint32_t x = 0; x < camera.width; x += 3) {
                double d[3], least = 1e9;
                REQUIRE(ray_of<double>(bounded, x + 0.5 - double{camera.cx}, y + 0.5 - double{camera.cy}, d));
                double low = 0, high = 20; // the response along a ray has one maximum
                for (int i = 0; i < 200; ++i) {
                    double const a = low + (high - low) / 3, b = high - (high - low) / 3;
                    auto const at = [&](double t) { return inverse({t * d[0] - g.mean_world[0], t * d[1] - g.mean_world[1], t * d[2] - g.mean_world[2]}); };
                    least = std::min(at(a), at(b));
                    (at(a) < at(b) ? high : low) = at(a) < at(b) ? b : a;
                }
                double const alpha = least <= 2 * std::log(double{g.opacity} / rules.alpha_min) ? double{g.opacity} * std::exp(-0.5 * least) : 0;
                double const shown = picture.rgb[3 * (std::size_t{y} * camera.width + x)];
                worst = std::max(worst, std::fabs(shown - std::min(alpha, double{rules.alpha_max}) * g.colour[0]));
                most = std::max(most, shown);
            }
        CHECK(worst < 1e-6);
        CHECK(most > 0.2 * g.colour[0]);

        // A picture of small Gaussians is that of their conics.
        auto small = support::cloud(200, 10);
        for (auto& s : small)
            for (float& v : s.log_scale) v = std::min(v, -5.0f);
        auto const wide = through(lens, 96, 60);
        auto const exact = report::render_exact_rays(small, wide, {}, 2), conics = report::render_naive(small, wide, {});
        double squares = 0;
        for (std::size_t i = 0; i < exact.rgb.size(); ++i) squares += std::pow(double{exact.rgb[i]} - conics.rgb[i], 2);
        CHECK(std::sqrt(squares / static_cast<double>(exact.rgb.size())) < 2e-3);
        CHECK(support::differing_pixels(exact, report::render_exact_rays(small, wide, {})) == 0); // any number of threads
    }
    Camera dark = through({LensKind::fisheye, {}, {}, 0, 0}, 32, 24);
    dark.fx = dark.fy = 5; // its corners are beyond 180 degrees
    auto const picture = report::render_exact_rays(std::vector<Gaussian>{}, dark, {});
    CHECK(std::isnan(picture.rgb[0]));
    CHECK(picture.rgb[3 * (12 * 32 + 16)] == 0);
}

TEST_CASE("who knows pinholes alone refuses a lens and a rolling shutter: a program of the tiles, an enclosure")
{
    auto const all = support::cloud(20, 6);
    auto const camera = through(lenses()[1].lens, 64, 40);
    auto const expected = [](char const* who) {
        return std::string("a camera with a lens that bends the picture (") + who +
               " knows pinholes alone); undistort the pictures, and give the pinhole camera that they have then";
    };
    RendererOptions const options{.grid = {2, 2}, .arithmetic = Arithmetic::precise};
    BasicRenderer<Lossless, CheckedMesh> by_value(support::map_of(all), options);
    CHECK(error_of([&] { by_value.render(camera); }) == expected("this program of the tiles"));
    struct Bent : Lossless {
        using Parameters = LensParameters;
    };
    BasicRenderer<Bent, CheckedMesh> bent(support::map_of(all), options);
    auto const straight = support::lens(64, 40);
    CHECK(support::differing_pixels(bent.render(straight).image, report::render_naive(all, straight, {})) == 0);
    CHECK(support::differing_pixels(bent.render(camera).image, report::render_naive(all, camera, {})) == 0);
    CHECK(error_of([&] { report::enclose(all, camera, {}); }).starts_with("no enclosure of a picture through a lens"));
    CHECK(scene::near_for(support::map_of(all), camera) > 0);

    auto rolling = straight;
    rolling.shutter = fast_hand;
    auto const at_once = [](char const* who) {
        return std::string("a camera with a rolling shutter (") + who +
               " takes a picture as seen at once); leave the shutter out, or take a camera that exposes all rows together";
    };
    CHECK(error_of([&] { by_value.render(rolling); }) == at_once("this program of the tiles"));
    CHECK(support::differing_pixels(bent.render(rolling).image, report::render_naive(all, rolling, {})) == 0);
    CHECK(error_of([&] { report::enclose(all, rolling, {}); }).starts_with("no enclosure of a picture through a lens"));
}
