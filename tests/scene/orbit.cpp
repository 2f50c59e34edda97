// test: needs data
#include "support.hpp"
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>

using namespace scene_test;
using namespace tilemesh;

namespace {

/// A Gaussian of one centimetre at a point.
splat::Gaussian at(float x, float y, float z, float log_scale = -4.6f)
{
    return {{x, y, z}, {1, 1, 1}, 1.0f, {1, 0, 0, 0}, {log_scale, log_scale, log_scale}, splat::GaussianId{1}};
}

scene::Map map_of(std::vector<splat::Gaussian> gaussians)
{
    scene::Map map;
    map.gaussians = std::move(gaussians);
    return map;
}

bool finite(splat::Camera const& c)
{
    auto const all = [](float const (&values)[3]) { return std::all_of(values, values + 3, [](float v) { return std::isfinite(v); }); };
    return std::all_of(c.rotation, c.rotation + 3, all) && all(c.position) && std::isfinite(c.fx) && c.fx > 0.0f && c.near_depth > 0.0f;
}

/// The share of a map's means that a camera shows.
double share_shown(splat::Camera const& camera, scene::Map const& map)
{
    std::size_t shown = 0;
    for (auto const& g : map.gaussians) {
        glm::dvec3 const p{g.mean_world[0], g.mean_world[1], g.mean_world[2]};
        if (to_view(camera, p).z <= static_cast<double>(camera.near_depth)) continue;
        auto const pixel = to_pixel(camera, p);
        shown += pixel.x >= 0 && pixel.y >= 0 && pixel.x < camera.width && pixel.y < camera.height;
    }
    return static_cast<double>(shown) / static_cast<double>(map.gaussians.size());
}

splat::Camera tilted()
{
    return scene::make_camera(scene::look_at({0.3, -1.0, -2.0}, {0.1, 0.2, 1.0}), scene::lens_from_field_of_view(60, {1280, 720}));
}

} // namespace

TEST_CASE("an orbit begins at its start and keeps distance, height and target")
{
    auto const start = tilted();
    glm::dvec3 const target{0.1, 0.2, 1.0};
    auto const cameras = scene::orbit(start, target, 7.5, 49);
    REQUIRE(cameras.size() == 49);
    CHECK(splat::same_view(cameras[0], start));
    auto const view = to_view(start, target);
    for (auto const& c : cameras) {
        CHECK(glm::length(to_view(c, target) - view) < 1e-5);
        CHECK(c.position[1] == start.position[1]);
        CHECK(c.fx == start.fx);
        CHECK(c.near_depth == start.near_depth);
    }
    // 48 frames are a whole turn; 12 a quarter, to the left of a camera that looks along +z.
    for (int i = 0; i < 3; ++i) CHECK(std::fabs(cameras[48].position[i] - start.position[i]) < 1e-5f);
    CHECK(cameras[12].position[0] == doctest::Approx(0.1 - 3.0).epsilon(1e-5));
    CHECK(cameras[12].position[2] == doctest::Approx(1.0 - 0.2).epsilon(1e-5));
    CHECK_FALSE(splat::same_view(cameras[1], start));
    CHECK(scene::orbit(start, target, 1.0, 0).empty());
    CHECK(scene::orbit(start, target, -1e9, 2).size() == 2);
    for (double const degrees : {1e308, -1.1e9, std::numeric_limits<double>::quiet_NaN()})
        CHECK(has(error_of([&] { scene::orbit(start, target, degrees, 1); }), "degrees a frame cannot be rendered"));
    CHECK(scene::orbit(start, target, 1.0, 1).size() == 1);
    // The opposite direction meets the same cameras, and no error accumulates.
    glm::dvec3 const ahead{0, 0, 1};
    auto const a = scene::orbit(start, ahead, -30.0, 2)[1], b = scene::orbit(start, ahead, 330.0, 2)[1];
    for (int i = 0; i < 3; ++i) CHECK(std::fabs(a.position[i] - b.position[i]) < 1e-6f);
    CHECK(splat::same_view(scene::orbit(start, ahead, 0.5, 21)[20], scene::orbit(start, ahead, 10.0, 2)[1]));
    // Steps of any size that is taken stay finite.
    for (double degrees : {1e9, -1e9, 1e8 / 3, 5e-324})
        for (auto const& camera : scene::orbit(scene::built_in_camera({64, 48}), {0, 0, 0}, degrees, 5)) {
            CHECK(finite(camera));
            for (int i = 0; i < 3; ++i) CHECK(std::abs(camera.rotation[i][0]) <= 1.0f);
        }
}

TEST_CASE("the recorded orbit is an orbit of this library")
{
    auto const path = data_file("trajectories/sloth_orbit.tum");
    if (path.empty()) return;
    auto const recorded = scene::load_tum(path);
    auto const lens = scene::lens_from_field_of_view(60, {1280, 720});

    // Frames 0 and 360 face each other across the axis.
    auto const centre = 0.5 * (recorded[0].pose.position + recorded[360].pose.position);
    auto const ours = scene::orbit(scene::make_camera(recorded[0].pose, lens), centre, 0.5, 720);
    for (std::size_t k : {1u, 90u, 200u, 719u}) {
        auto const pose = scene::pose_of(ours[k]);
        CAPTURE(k);
        CHECK(glm::length(pose.position - recorded[k].pose.position) < 1e-3);
        for (int i = 0; i < 3; ++i) CHECK(glm::length(pose.rotation[i] - recorded[k].pose.rotation[i]) < 1e-3);
    }
}

TEST_CASE("the robust centre is the median, not the mean")
{
    CHECK(scene::robust_centre({}) == glm::dvec3{0.0});
    CHECK(scene::robust_centre(map_of({at(1, 2, 3)})) == glm::dvec3{1, 2, 3});
    CHECK(scene::robust_centre(map_of({at(1, 5, 3), at(2, 4, 1e30f), at(-1e30f, 6, 2)})) == glm::dvec3{1, 5, 3});
    CHECK(scene::robust_centre(map_of({at(1, 0, 0), at(2, 0, 0)})).x == 2.0);
}

TEST_CASE("a framed map is in the picture, outliers or not")
{
    scene::Map map;
    for (int i = 0; i < 1000; ++i)
        map.gaussians.push_back(
            at(0.01f * static_cast<float>(i % 10), 0.01f * static_cast<float>(i / 10 % 10), 5.0f + 0.01f * static_cast<float>(i / 100)));
    auto const camera = scene::frame_whole(map, {1280, 720});
    CHECK(share_shown(camera, map) == 1.0);
    CHECK(camera.width == 1280);
    CHECK(camera.fx == doctest::Approx(640.0 / std::tan(0.5235987756)));
    CHECK(camera.rotation[2][2] == 1.0f);
    CHECK(camera.rotation[0][0] == 1.0f);
    CHECK(camera.position[2] < 5.0f);

    // It fills the picture: the wall is a tenth of a metre high.
    CHECK(to_pixel(camera, {0.045, 0.09, 5.0}).y - to_pixel(camera, {0.045, 0.0, 5.0}).y > 0.3 * 720);

    auto with_outliers = map;
    for (int i = 0; i < 40; ++i) with_outliers.gaussians.push_back(at(1e20f, -1e20f, i % 2 ? -1e20f : 1e20f));
    auto const robust = scene::frame_whole(with_outliers, {1280, 720});
    CHECK(share_shown(robust, map) == 1.0);
    CHECK(std::fabs(robust.position[2] - camera.position[2]) < 0.1f);
}

TEST_CASE("any map can be framed, in any shape of picture")
{
    float const huge = std::numeric_limits<float>::max();
    std::vector<scene::Map> const maps{
        map_of({}), map_of({at(1, 2, 3)}), map_of({at(1, 2, 3), at(1, 2, 3), at(1, 2, 3)}), map_of({at(1, 2, 3, -87.0f), at(1, 2, 3, -87.0f)}),
        map_of({at(1e6f, -1e6f, 1e6f, -20.0f)}), map_of({at(0, 0, 0, -30.0f)}), map_of({at(-1, 0, 0), at(1, 0, 0)}),
        map_of({at(huge, huge, huge), at(-huge, -huge, -huge)}), map_of({at(0, 0, 0, 200.0f)})};
    for (std::size_t i = 0; i < maps.size(); ++i)
        for (scene::Size const size : {scene::Size{1280, 720}, scene::Size{100, 1000}, scene::Size{1, 1}}) {
            CAPTURE(i);
            auto const camera = scene::frame_whole(maps[i], size);
            CHECK(finite(camera));
            CHECK(camera.near_depth <= 0.2f);
            if (i > 0 && i < 6) CHECK(share_shown(camera, maps[i]) == 1.0);
        }
    CHECK(has(error_of([&] { scene::frame_whole(maps[1], {0, 0}); }), "0 x 0"));
    // The near plane follows the map down.
    CHECK(scene::frame_whole(map_of({at(0, 0, 0, 0.0f)}), {64, 64}).near_depth == 0.2f);
    CHECK(scene::frame_whole(map_of({at(0, 0, 0, -9.0f)}), {64, 64}).near_depth < 1e-3f);
}

TEST_CASE("a camera stands upright in a map with any direction up")
{
    // The map of a wall, and the same map turned so that another axis is up. The pictures of both are one picture.
    scene::Map map;
    for (int i = 0; i < 100; ++i) map.gaussians.push_back(at(0.01f * static_cast<float>(i % 10), 0.03f * static_cast<float>(i / 10), 5.0f + 0.001f * static_cast<float>(i)));
    scene::Size const size{640, 360};
    auto const plain = scene::frame_whole(map, size);
    auto const start = scene::look_at({0.3, -0.2, 1.0}, {0, 0, 5});
    auto const lens = scene::lens_from_field_of_view(60.0, size);
    auto const orbit = scene::orbit(scene::make_camera(start, lens), {0, 0, 5}, 30.0, 4);
    for (auto const up : {glm::dvec3{0, -1, 0}, glm::dvec3{0, 3, 0}, glm::dvec3{0, 0, 2}, glm::dvec3{0, 0, -1}, glm::dvec3{1, 0, 0}, glm::dvec3{0.3, 0.4, -0.1}}) {
        glm::dmat3 const to_upright = scene::upright(up), to_world = glm::transpose(to_upright);
        CHECK(glm::determinant(to_upright) == doctest::Approx(1.0));
        CHECK((to_upright * up).y == doctest::Approx(-glm::length(up)));
        CHECK(std::fabs((to_upright * up).x) < 1e-12);
        auto turned = map;
        for (auto& g : turned.gaussians) {
            glm::dvec3 const world = to_world * glm::dvec3{g.mean_world[0], g.mean_world[1], g.mean_world[2]};
            for (int axis = 0; axis < 3; ++axis) g.mean_world[axis] = static_cast<float>(world[axis]);
        }
        auto const same_view = [&](splat::Camera const& a, splat::Camera const& b) { // of the map, and of the turned map
            for (auto const& point : {glm::dvec3{0, 0, 5}, glm::dvec3{0.09, 0.27, 5.1}}) {
                CHECK(to_pixel(a, point).x == doctest::Approx(to_pixel(b, to_world * point).x).epsilon(1e-4));
                CHECK(to_pixel(a, point).y == doctest::Approx(to_pixel(b, to_world * point).y).epsilon(1e-4));
            }
        };
        same_view(plain, scene::frame_whole(turned, size, up));
        auto const turned_start = scene::make_camera({start.rotation * to_upright, to_world * start.position}, lens);
        auto const turned_orbit = scene::orbit(turned_start, to_world * glm::dvec3{0, 0, 5}, 30.0, 4, up);
        for (std::size_t i = 0; i < orbit.size(); ++i) same_view(orbit[i], turned_orbit[i]);
    }
    CHECK(splat::same_view(plain, scene::frame_whole(map, size, {0, -2, 0})));
    CHECK(scene::frame_whole(map, size, {0, -1, 0}, 90.0).fx == doctest::Approx(320.0));
    CHECK(has(error_of([&] { scene::frame_whole(map, size, {0, 0, 0}); }), "a direction of length 0 is no up"));
    CHECK(has(error_of([&] { scene::orbit(plain, {0, 0, 0}, 1.0, 2, {0, 0, 0}); }), "a direction of length 0 is no up"));
    CHECK(has(error_of([&] { scene::frame_whole(map, size, {0, -1, 0}, 180.0); }), "between 0 and 180"));
}

TEST_CASE("the camera of a reduced photograph sees the whole view in other pixels")
{
    auto const camera = scene::make_camera({}, {500, 510, 321, 239, 0.2f, 641, 479});
    auto const x = [](double v) { return static_cast<float>(v * 320 / 641); };
    auto const y = [](double v) { return static_cast<float>(v * 240 / 479); };
    check_lens(scene::stretched(camera, {320, 240}), 320, 240, x(500), y(510), x(321), y(239));
    CHECK(splat::same_view(camera, scene::stretched(camera, {641, 479})));
    CHECK(has(error_of([&] { scene::stretched(camera, {0, 4}); }), "0 x 4"));

    // As Python's round(): a half goes to the even number.
    std::uint32_t const sides[][3] = {{641, 2, 320}, {643, 2, 322}, {642, 2, 321}, {4946, 4, 1236}, {3286, 4, 822}, {5, 3, 2}, {4, 3, 1}, {1, 64, 1}, {65535, 1, 65535}, {32, 64, 1}, {96, 64, 2}};
    for (auto const& [side, factor, expected] : sides) {
        CHECK(scene::reduced({side, 7}, factor).width == expected);
        CHECK(scene::reduced({7, side}, factor).height == expected);
    }
}
