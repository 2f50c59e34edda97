#include "support.hpp"
#include <cmath>
#include <cstring>
#include <doctest/doctest.h>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/pose.hpp>
#include <vector>

using namespace scene_test;
using namespace tilemesh;
using nlohmann::json;

namespace {

json entry(std::string const& scene, std::string const& name)
{
    // A quarter turn about y: the camera looks along world -x.
    return {{"scene", scene},
            {"file", scene + ".ply"},
            {"name", name},
            {"width", 640},
            {"height", 480},
            {"fx", 500.0},
            {"fy", 510.0},
            {"cx", 320.5},
            {"cy", 239.5},
            {"near", 0.05},
            {"world_to_camera", {{0, 0, 1, 1}, {0, 1, 0, 2}, {-1, 0, 0, 3}, {0, 0, 0, 1}}}};
}

std::string file_of(std::vector<json> const& cameras)
{
    json file;
    file["cameras"] = cameras;
    return file.dump();
}

std::vector<scene::NamedCamera> load(std::vector<json> const& cameras)
{
    TempFile const file(file_of(cameras), ".json");
    return scene::load_cameras(file.path());
}

template <class Change>
std::string refusal(Change change)
{
    json broken = entry("desk", "left");
    change(broken);
    return error_of([&] { load({entry("desk", "front"), broken}); });
}

std::string refused_text(std::string const& text)
{
    TempFile const file(text, ".json");
    return error_of([&] { scene::load_cameras(file.path()); });
}

} // namespace

TEST_CASE("a camera file is read field by field")
{
    auto const cameras = load({entry("desk", "front")});
    REQUIRE(cameras.size() == 1);
    CHECK(cameras[0].scene == "desk");
    CHECK(cameras[0].file == "desk.ply");
    CHECK(cameras[0].name == "front");
    auto const& c = cameras[0].camera;
    CHECK(c.width == 640);
    CHECK(c.height == 480);
    CHECK(c.fx == 500.0f);
    CHECK(c.fy == 510.0f);
    CHECK(c.cx == 320.5f);
    CHECK(c.cy == 239.5f);
    CHECK(c.near_depth == 0.05f);
    CHECK(c.rotation[0][2] == 1.0f);
    CHECK(c.rotation[2][0] == -1.0f);
    CHECK(c.position[0] == 3.0f);
    CHECK(c.position[1] == -2.0f);
    CHECK(c.position[2] == -1.0f);

    json plain = entry("desk", "front");
    plain.erase("near");
    plain.erase("file");
    CHECK(load({plain})[0].camera.near_depth == 0.2f);
    CHECK(load({plain})[0].file.empty());
    CHECK(load({}).empty());
}

TEST_CASE("what is wrong with a camera is said in one line that names it")
{
    auto const says = [](std::string const& text, char const* word) {
        return has(text, "camera desk/left") && has(text, word);
    };
    for (char const* key : {"width", "height", "fx", "fy", "cx", "cy", "world_to_camera"}) {
        CHECK(says(refusal([&](json& c) { c.erase(key); }), key));
        CHECK(says(refusal([&](json& c) { c[key] = "wide"; }), key));
    }
    for (double const side : {0.0, -1.0, 65536.0, 12.5}) {
        CHECK(says(refusal([&](json& c) { c["width"] = side; }), "1 to 65535"));
        CHECK(says(refusal([&](json& c) { c["height"] = side; }), "1 to 65535"));
    }
    for (char const* key : {"fx", "fy", "near"})
        for (double const value : {0.0, -1.0, 1e-60}) {
            CHECK(says(refusal([&](json& c) { c[key] = value; }), "not positive"));
            CHECK(says(refusal([&](json& c) { c[key] = value; }), key));
        }
    CHECK(says(refusal([](json& c) { c["cx"] = nullptr; }), "not a finite number"));
    CHECK(says(refusal([](json& c) { c["cx"] = 1e300; }), "not a finite number"));
    CHECK(says(refusal([](json& c) { c["world_to_camera"].erase(3); }), "4x4"));
    CHECK(says(refusal([](json& c) { c["world_to_camera"][1].push_back(0); }), "4x4"));
    CHECK(says(refusal([](json& c) { c["world_to_camera"][3][0] = 1; }), "last row"));
    CHECK(says(refusal([](json& c) { c["world_to_camera"][0][2] = 1.002; }), "orthonormal"));
    CHECK(says(refusal([](json& c) { c["world_to_camera"][0][2] = -1; }), "mirrored"));
    CHECK(refusal([](json& c) { c["world_to_camera"][0][2] = 1.0004; }).empty());

    CHECK(has(refusal([](json& c) { c.erase("name"); }), "camera 2"));
    CHECK(has(refusal([](json& c) { c["scene"] = 7; }), "\"scene\" is not a string"));
    CHECK(has(refusal([](json& c) { c["name"] = "front"; }), "same scene and name"));
    CHECK(has(refusal([](json& c) { c = 5; }), "camera 2"));
    CHECK(load({entry("desk", "a"), entry("desk", "b")}).size() == 2);
}

TEST_CASE("what is no camera file is refused")
{
    auto const folder = std::filesystem::temp_directory_path();
    CHECK(
        has(error_of([&] { scene::load_cameras(folder / "tilemesh_none.json"); }), "no such file"));
    CHECK(has(error_of([&] { scene::load_cameras(folder); }), "directory"));
    CHECK(has(refused_text(""), "not JSON"));
    CHECK(has(refused_text("{\"cameras\": [\n1,"), "not JSON"));
    CHECK(has(refused_text("[]"), "cameras"));
    CHECK(has(refused_text("{\"cameras\": 3}"), "cameras"));
}

TEST_CASE("a selector finds its cameras or lists the choices")
{
    auto const all = load({entry("desk", "front"), entry("desk", "left"), entry("hall", "front")});
    auto const names = [&](std::string const& selector, std::string const& map) {
        std::string text;
        for (auto const& c : scene::select_cameras(all, selector, map))
            text += c.scene + "/" + c.name + " ";
        return text;
    };
    CHECK(names("hall/front", "desk") == "hall/front ");
    CHECK(names("left", "hall") == "desk/left ");
    CHECK(names("", "desk") == "desk/front desk/left ");
    CHECK(names("", "hall.ply") == "hall/front ");

    CHECK(names("front", "desk") == "desk/front "); // of several, the one of the map's own scene
    std::string const ambiguous = error_of([&] { names("front", "sloth"); });
    CHECK(has(ambiguous, "ambiguous"));
    CHECK(has(ambiguous, "desk/front, hall/front"));
    CHECK(has(error_of([&] { names("desk/right", "desk"); }), "desk/front, desk/left, hall/front"));
    CHECK(has(error_of([&] { names("", "sloth"); }), "no camera belongs to map \"sloth\""));
    CHECK(has(error_of([&] { scene::select_cameras({}, "", "desk"); }), "empty"));
}

TEST_CASE("a map's cameras are found by file where the scene has another name")
{
    json camera = entry("desk", "front");
    camera["file"] = "scan_7.ply";
    auto const all = load({camera});
    CHECK(scene::select_cameras(all, "", "scan_7").size() == 1);
    CHECK(scene::select_cameras(all, "", "scan_7.ply").size() == 1);
    CHECK(has(error_of([&] { scene::select_cameras(all, "", "scan"); }), "no camera"));
}

TEST_CASE("the cameras of the paper's maps show points where their matrices do")
{
    auto const path = data_file("cameras.json");
    if (path.empty()) return;
    auto const cameras = scene::load_cameras(path);
    CHECK(cameras.size() == 8);
    std::ifstream stream(path);
    auto const file = json::parse(stream);
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        auto const& m = file["cameras"][i]["world_to_camera"];
        for (glm::dvec3 const p :
             {glm::dvec3{0, 0, 0}, glm::dvec3{1, 2, 3}, glm::dvec3{-2, 0.5, 4}}) {
            auto const view = to_view(cameras[i].camera, p);
            for (int row = 0; row < 3; ++row) {
                auto const& r = m[static_cast<std::size_t>(row)];
                double const expected = r[0].get<double>() * p.x + r[1].get<double>() * p.y +
                                        r[2].get<double>() * p.z + r[3].get<double>();
                CHECK(std::fabs(view[row] - expected) < 1e-5);
            }
        }
    }
    CHECK(scene::select_cameras(cameras, "", "sloth").size() == 4);
    CHECK(scene::select_cameras(cameras, "salad/benchmark", "sloth").size() == 1);
}

TEST_CASE("a camera that looks at a point has it on its axis")
{
    glm::dvec3 const eye{1.0, -2.0, 0.5}, target{-3.0, 1.0, 4.0};
    auto const lens = scene::lens_from_field_of_view(60.0, {1280, 720});
    auto const camera = scene::make_camera(scene::look_at(eye, target), lens);
    auto const view = to_view(camera, target);
    CHECK(std::fabs(view.x) < 1e-6);
    CHECK(std::fabs(view.y) < 1e-6);
    CHECK(view.z == doctest::Approx(glm::length(target - eye)));
    // What lies further down in the world is lower in the picture; right is right.
    CHECK(to_pixel(camera, target + glm::dvec3{0, 0.1, 0}).y > 361.0);
    auto const pose = scene::look_at({0, 0, 0}, {0, 0, 1});
    CHECK(pose.rotation == glm::dmat3{1.0});
    CHECK(has(error_of([&] { scene::look_at(eye, eye); }), "own position"));
}

TEST_CASE("looking straight down is still a rotation")
{
    for (double const way : {1.0, -1.0}) {
        auto const r = scene::look_at({0, 0, 0}, {0, way, 0}).rotation;
        CHECK(glm::determinant(r) == doctest::Approx(1.0));
        CHECK((r * glm::dvec3{0, way, 0}).z == doctest::Approx(1.0));
    }
}

TEST_CASE("a field of view spans the picture from border to border")
{
    auto const lens = scene::lens_from_field_of_view(90.0, {1000, 400});
    CHECK(lens.fx == doctest::Approx(500.0));
    CHECK(lens.fy == lens.fx);
    CHECK(lens.cx == 500.0);
    CHECK(lens.cy == 200.0);
    CHECK(lens.near_depth == 0.2f);
    for (double const bad : {0.0, -1.0, 180.0, std::nan("")})
        CHECK(has(error_of([&] {
                      scene::lens_from_field_of_view(bad, {10, 10});
                  }),
                  "field of view"));
    CHECK(has(error_of([&] { scene::lens_from_field_of_view(60, {0, 10}); }), "0 x 10"));
    CHECK(has(error_of([&] { scene::lens_from_field_of_view(60, {10, 65536}); }), "65536"));
}

TEST_CASE("resizing keeps the horizontal field of view")
{
    auto camera = load({entry("desk", "front")})[0].camera;
    CHECK(splat::same_view(scene::resized(camera, 640, 480), camera));
    auto const half = scene::resized(camera, 320, 480);
    CHECK(half.fx == 250.0f);
    CHECK(half.fy == 255.0f);
    CHECK(half.cx == 160.25f);
    CHECK(half.cy == 239.5f);
    CHECK(half.width == 320);
    auto const tall = scene::resized(camera, 640, 960);
    CHECK(tall.fy == 510.0f);
    CHECK(tall.cy == 479.0f);
    CHECK(has(error_of([&] { scene::resized(camera, 640, 0); }), "640 x 0"));
}

TEST_CASE("a camera survives the way to a pose and back in every bit")
{
    splat::Camera const camera{{{0.1f, 0.2f, 0.3f}, {0.4f, 0.5f, 0.6f}, {0.7f, 0.8f, 0.9f}},
                               {1e-30f, -7.3f, 1e6f},
                               501.1f,
                               502.2f,
                               3.3f,
                               4.4f,
                               0.01f,
                               11,
                               12};
    CHECK(splat::same_view(scene::make_camera(scene::pose_of(camera), scene::lens_of(camera)),
                           camera));
}

TEST_CASE("quaternions turn as they should at any length")
{
    double const h = std::sqrt(0.5);
    for (double const length : {1.0, 1e-300, 1e300}) {
        // A quarter turn about z carries x to y.
        auto const turned =
            scene::rotation_matrix(h * length, 0, 0, h * length) * glm::dvec3{1, 0, 0};
        CHECK(std::fabs(turned.x) < 1e-15);
        CHECK(turned.y == doctest::Approx(1.0));
        // About x: y to z. About y: z to x.
        CHECK((scene::rotation_matrix(h * length, h * length, 0, 0) * glm::dvec3{0, 1, 0}).z ==
              doctest::Approx(1.0));
        CHECK((scene::rotation_matrix(h * length, 0, h * length, 0) * glm::dvec3{0, 0, 1}).x ==
              doctest::Approx(1.0));
    }
    CHECK(scene::rotation_matrix(0, 0, 0, 0) == glm::dmat3{1.0});
}
