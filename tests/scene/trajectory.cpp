#include "support.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <tilemesh/scene/camera_json.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <utility>

using namespace scene_test;
using namespace tilemesh;

namespace {

scene::Trajectory load(std::string const& text)
{
    TempFile const file(text, ".tum");
    return scene::load_tum(file.path());
}
std::string refusal(std::string const& text)
{
    return error_of([&] { load(text); });
}

double distance(glm::dmat3 const& a, glm::dmat3 const& b)
{
    double most = 0.0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) most = std::fmax(most, std::fabs(a[i][j] - b[i][j]));
    return most;
}

} // namespace

TEST_CASE("a TUM line is camera to world")
{
    // A quarter turn about y, of length 2: the camera looks along world +x.
    auto const poses = load("# a comment\n\n  \t\n1.5 1 2 3 0 1.41421356237 0 1.41421356237\r\n"
                            "   # another\n-2e3\t+0.5 0 0 0 0 0 -3");
    REQUIRE(poses.size() == 2);
    CHECK(poses[0].seconds == 1.5);
    CHECK(poses[0].pose.position == glm::dvec3{1, 2, 3});
    auto const ahead = poses[0].pose.rotation * glm::dvec3{1, 0, 0};
    CHECK(ahead.z == doctest::Approx(1.0));
    CHECK(std::fabs(ahead.x) < 1e-9);
    CHECK(poses[1].seconds == -2000.0);
    CHECK(poses[1].pose.position.x == 0.5);
    CHECK(distance(poses[1].pose.rotation, glm::dmat3{1.0}) < 1e-15);
}

TEST_CASE("a bad line is named by its number")
{
    std::string const good = "0 0 0 0 0 0 0 1\n";
    CHECK(load(good).size() == 1);
    CHECK(has(refusal("# c\n" + good + "0 0 0 0 0 0 1\n"), "line 3"));
    CHECK(has(refusal(good + "0 0 0 0 0 0 1\n"), "7 fields"));
    CHECK(has(refusal(good + "0 0 0 0 0 0 0 1 9\n"), "9 fields"));
    CHECK(has(refusal(good + "\n0 0 0 0 0 0 0 0\n"), "line 3"));
    CHECK(has(refusal("0 0 0 0 0 0 0 0\n"), "zero"));
    CHECK(has(refusal("0 0 x 0 0 0 0 1\n"), "field 3"));
    CHECK(has(refusal("0 0 0 1.2.3 0 0 0 1\n"), "field 4"));
    for (char const* bad : {"nan", "inf", "-inf", "1e999", "+", "1,0"})
        CHECK(has(refusal(std::string("0 0 0 0 0 0 0 ") + bad), "field 8"));
}

TEST_CASE("a file without a pose, or no file, is refused")
{
    CHECK(has(refusal(""), "no pose"));
    CHECK(has(refusal("# only\n\n"), "no pose"));
    auto const folder = std::filesystem::temp_directory_path();
    CHECK(has(error_of([&] { scene::load_tum(folder / "tilemesh_none.tum"); }), "no such file"));
    CHECK(has(error_of([&] { scene::load_tum(folder); }), "directory"));
}

TEST_CASE("motion since the first pose is carried out from the start, in the camera's own axes")
{
    // First looks along world +x; one step ahead and a quarter turn about its own y axis.
    auto const recorded = load("0 5 5 5 0 0.70710678118 0 0.70710678118\n1 6 5 5 0 1 0 0\n");
    scene::Pose const start = scene::look_at({1, 0, 0}, {1, 0, 9}); // looks along +z
    auto const moved = scene::relative_to_first(recorded, start);
    REQUIRE(moved.size() == 2);
    CHECK(moved[0].pose.rotation == start.rotation);
    CHECK(moved[0].pose.position == start.position);
    CHECK(moved[1].seconds == 1.0);
    CHECK(glm::length(moved[1].pose.position - glm::dvec3{1, 0, 1}) < 1e-9);
    CHECK((moved[1].pose.rotation * glm::dvec3{1, 0, 0}).z ==
          doctest::Approx(1.0)); // looks along +x
    CHECK(scene::relative_to_first({}, start).empty());
}

TEST_CASE("started from its own first pose a trajectory stays what it is")
{
    auto const path = data_file("trajectories/fr1_xyz.tum");
    if (path.empty()) return;
    auto const recorded = scene::load_tum(path);
    CHECK(recorded.size() > 100);
    auto const same = scene::relative_to_first(recorded, recorded.front().pose);
    double most = 0.0;
    for (std::size_t i = 0; i < same.size(); ++i) {
        most = std::fmax(most, glm::length(same[i].pose.position - recorded[i].pose.position));
        most = std::fmax(most, distance(same[i].pose.rotation, recorded[i].pose.rotation));
    }
    CHECK(most < 1e-12);
    CHECK(glm::length(recorded.back().pose.position - recorded.front().pose.position) > 1e-3);
}

TEST_CASE("the recorded orbits begin at the benchmark cameras")
{
    for (std::string const name : {"sloth", "salad"}) {
        auto const orbit = data_file("trajectories/" + name + "_orbit.tum");
        auto const file = data_file("cameras.json");
        if (orbit.empty() || file.empty()) continue;
        auto const poses = scene::load_tum(orbit);
        CHECK(poses.size() == 720);
        auto const named =
            scene::select_cameras(scene::load_cameras(file), name + "/benchmark", name);
        scene::Pose const expected = scene::pose_of(named.at(0).camera);
        CHECK(distance(poses[0].pose.rotation, expected.rotation) < 1e-4);
        CHECK(glm::length(poses[0].pose.position - expected.position) < 1e-4);
    }
}
