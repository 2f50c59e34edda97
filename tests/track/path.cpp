#include "../../examples/shared/camera_path.hpp"
#include "../standard.hpp"
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>

namespace scene = tilemesh::scene;
using shared::CameraPath;
using shared::nearest_poses;

TEST_SUITE_BEGIN("track/path");

namespace {

scene::Trajectory poses_at(std::vector<double> const& times)
{
    scene::Trajectory poses;
    for (double const t : times) poses.push_back({t, {}});
    return poses;
}

/// What `nearest_poses` should find for one picture: a look at every pose, of which the first of the nearest counts.
std::optional<std::size_t> nearest_of_all(double t, scene::Trajectory const& poses, double most)
{
    std::optional<std::size_t> best;
    for (std::size_t i = 0; i < poses.size(); ++i)
        if (double const away = std::fabs(poses[i].seconds - t); away <= most && (!best || away < std::fabs(poses[*best].seconds - t))) best = i;
    return best;
}

} // namespace

TEST_CASE("the nearest pose of a picture, in chosen cases")
{
    using Found = std::vector<std::optional<std::size_t>>;
    CHECK(nearest_poses({}, poses_at({1, 2}), 1).of_picture.empty());
    CHECK(nearest_poses({1, 2}, {}, 1).of_picture == Found{std::nullopt, std::nullopt});
    CHECK(nearest_poses({0, 1.5, 4}, poses_at({1, 2}), 1).of_picture == Found{0, 0, std::nullopt}); // equally near: the first in the list
    CHECK(nearest_poses({1.5}, poses_at({2, 1}), 1).of_picture == Found{0});
    CHECK(nearest_poses({3}, poses_at({2, 2, 2}), 1).of_picture == Found{0});
    CHECK(nearest_poses({1, 1, 3}, poses_at({3, 1, 1}), 0).of_picture == Found{1, 1, 0});
}

TEST_CASE("the nearest pose of a picture is that of a look at every pose, in any order of poses and with equal stamps")
{
    std::mt19937 random{1};
    for (int round = 0; round < 300; ++round) {
        // Multiples of 1/8: distances are exact, so that many are equal.
        auto const time = [&] { return static_cast<double>(random() % 64u) / 8.0; };
        std::vector<double> times(random() % 20u), stamps(random() % 20u);
        for (double& each : times) each = time();
        for (double& each : stamps) each = time();
        std::sort(times.begin(), times.end());
        auto const poses = poses_at(stamps);
        double const most = static_cast<double>(random() % 8u) / 8.0;
        auto const found = nearest_poses(times, poses, most).of_picture;
        REQUIRE(found.size() == times.size());
        for (std::size_t i = 0; i < times.size(); ++i) CHECK(found[i] == nearest_of_all(times[i], poses, most));
    }
}

TEST_CASE("every pose and every picture is looked at once")
{
    for (std::size_t const n : {100u, 10000u}) {
        std::vector<double> times, stamps;
        for (std::size_t i = 0; i < n; ++i) {
            times.push_back(0.03 * static_cast<double>(i));
            stamps.push_back(0.03 * static_cast<double>(n - 1 - i));
        }
        auto const found = nearest_poses(times, poses_at(stamps), 0.02);
        CHECK(found.steps <= 2 * n);
        CHECK(found.of_picture.front() == n - 1);
        CHECK(found.of_picture.back() == 0);
    }
}

TEST_CASE("a hand-held motion of 10^12 poses costs nothing until a pose is asked for")
{
    scene::Pose first;
    first.position = {1, 2, 3};
    CameraPath const path{first, std::uint64_t{1'000'000} * 1'000'000};
    CHECK(path.size() == 1'000'000'000'000);
    CHECK(path[0].seconds == 0.0);
    CHECK(path[0].pose.position == first.position);
    CHECK(path[999'999'999'999].seconds == 999'999'999'999.0 / 31.0);
    // About 1 cm a pose, and the way back is not far.
    for (std::uint64_t k : {0u, 100u, 4000u}) {
        double const step = glm::length(path[k + 1].pose.position - path[k].pose.position);
        CHECK(step > 0.0005);
        CHECK(step < 0.03);
        CHECK(glm::length(path[k].pose.position - first.position) < 0.3);
    }
}

TEST_CASE("a path of a trajectory has its poses")
{
    auto poses = poses_at({3, 1, 2});
    poses[1].pose.position = {4, 5, 6};
    CameraPath const path{poses};
    CHECK(path.size() == 3);
    CHECK(path[0].seconds == 3.0);
    CHECK(path[1].pose.position == glm::dvec3{4, 5, 6});
}

TEST_SUITE_END();
