// test: unoptimised test asan
// The near plane of cameras that name none, and what it hides.
#include "../splat/support.hpp"
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/scene/near_plane.hpp>

using namespace tilemesh;

namespace {

/// `n` Gaussians in front of the camera, in the middle of the picture, at depths from `first` on, `step` apart.
scene::Map row_of(std::uint32_t n, float first, float step)
{
    scene::Map map;
    for (std::uint32_t i = 0; i < n; ++i) {
        splat::Gaussian g{};
        g.mean_world[2] = first + step * static_cast<float>(i);
        g.rotation[0] = 1;
        g.opacity = 0.5f;
        for (float& s : g.log_scale) s = -6;
        g.id = splat::GaussianId{i + 1};
        map.gaussians.push_back(g);
    }
    return map;
}
splat::Camera camera() { return support::lens(64, 48); }

} // namespace

TEST_CASE("the near plane is a tenth of the median depth of what the picture shows, at most 0.2")
{
    CHECK(scene::near_for(row_of(0, 1, 1), camera()) == scene::default_near);
    CHECK(scene::near_for(row_of(1, 2, 0), camera()) == doctest::Approx(0.2));
    CHECK(scene::near_for(row_of(1, 1, 0), camera()) == doctest::Approx(0.1));
    CHECK(scene::near_for(row_of(101, 10, 1), camera()) == scene::default_near);
    CHECK(scene::near_for(row_of(101, 0.01f, 0.01f), camera()) == doctest::Approx(0.051));
    // What is behind the camera or beside the picture does not count.
    auto map = row_of(5, 0.5f, 0);
    for (int i = 0; i < 100; ++i) {
        map.gaussians.push_back(map.gaussians[0]);
        map.gaussians.back().mean_world[2] = i % 2 == 0 ? -0.01f : 0.01f;
        map.gaussians.back().mean_world[0] = i % 2 == 0 ? 0 : 1;
    }
    CHECK(scene::near_for(map, camera()) == doctest::Approx(0.05));
    // The unit of the world scales it; a map so small that floats end has a plane above 0.
    for (float const unit : {1e-3f, 1e-6f, 1e-12f, 1e-38f}) {
        auto const near = scene::near_for(row_of(9, 3 * unit, 0), camera());
        CHECK(near > 0);
        CHECK(near == doctest::Approx(std::max(0.3 * double{unit}, 1.17549435e-38)));
    }
    // A sample decides for a large map.
    CHECK(scene::near_for(row_of(50'000, 0.01f, 1e-5f), camera()) == doctest::Approx(0.026).epsilon(0.01));
}

TEST_CASE("cameras that name a near plane keep it")
{
    std::string const rest = R"("width": 64, "height": 48, "fx": 40, "fy": 40, "cx": 32, "cy": 24,
        "world_to_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]})";
    std::istringstream file(R"({"cameras": [{"name": "a", "near": 0.15, )" + rest + R"(, {"name": "b", )" + rest + "]}");
    auto cameras = scene::read_cameras_json(file, "cameras.json");
    REQUIRE(cameras.size() == 2);
    CHECK(cameras[0].names_near);
    CHECK_FALSE(cameras[1].names_near);
    CHECK(cameras[1].camera.near_depth == scene::default_near);
    scene::choose_near(cameras, row_of(3, 0.5f, 0));
    CHECK(cameras[0].camera.near_depth == 0.15f);
    CHECK(cameras[1].camera.near_depth == doctest::Approx(0.05));
}

TEST_CASE("the demand counts what only the near plane hides, in the view that has most of it")
{
    auto map = row_of(10, 0.05f, 0.05f); // 0.05 ... 0.5
    auto view = camera();
    view.near_depth = 0.2f;
    auto beside = map.gaussians[0]; // not in the picture
    beside.mean_world[0] = 1;
    auto behind = map.gaussians[0];
    behind.mean_world[2] = -0.1f;
    auto faint = map.gaussians[0];
    faint.opacity = 1e-3f;
    for (auto g : {beside, behind, faint}) map.gaussians.push_back(g);
    auto const tiling_of = [](splat::Camera const& c) { return splat::make_tiling(c.width, c.height, 16, 16); };
    auto const nearer = [&](std::vector<splat::Camera> const& path) { return scene::demand_of(map, path, {}, tiling_of).nearer; };
    auto const brute = [&](splat::Camera const& c) {
        std::uint64_t n = 0;
        for (auto const& g : map.gaussians) n += scene::only_near_hides(g, splat::make_view(c, {})) ? 1 : 0;
        return n;
    };
    CHECK(brute(view) == 4); // 0.05, 0.1, 0.15, 0.2: the plane itself hides
    CHECK(nearer({view}) == 4);
    auto all = view, none = view;
    all.near_depth = 1;
    none.near_depth = 0.01f;
    CHECK(nearer({none}) == 0);
    CHECK(nearer({none, view, all, view}) == 10);
    CHECK(nearer({}) == 0);
}
