#include "require.hpp"
#include <cmath>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/trajectory.hpp>
#include <tilemesh/splat/camera.hpp>

namespace {

using namespace tilemesh;

/// Stamp and place are finite, and the rotation is one.
void require_pose(scene::StampedPose const& stamped, double tolerance)
{
    require(std::isfinite(stamped.seconds), "stamps are finite");
    auto const& pose = stamped.pose;
    glm::dmat3 const square = glm::transpose(pose.rotation) * pose.rotation;
    for (int i = 0; i < 3; ++i) {
        require(std::isfinite(pose.position[i]), "places are finite");
        for (int j = 0; j < 3; ++j) require(std::fabs(square[i][j] - (i == j ? 1.0 : 0.0)) <= tolerance, "the rotation is orthonormal");
    }
    require(glm::determinant(pose.rotation) > 0.0, "the rotation is not mirrored");
}
/// The same holds for the camera that is rendered from it.
void require_camera(scene::StampedPose const& stamped)
{
    require_pose(stamped, 1e-12);
    auto const camera = scene::make_camera(stamped.pose, {500.0, 500.0, 320.0, 240.0, 0.2f, 640, 480});
    for (float const place : camera.position) require(std::isfinite(place), "the centre is finite");
}
void require_notes(scene::Trajectory const& trajectory, std::size_t most)
{
    auto const notes = scene::trajectory_notes(trajectory);
    require(notes.size() <= most && std::all_of(notes.begin(), notes.end(), is_one_line), "notes are a handful of lines");
}

/// A trajectory is written as TUM, and read back. A rotation that a file gives as a matrix is orthonormal within 1e-3 alone.
void require_written(scene::Trajectory const& trajectory)
{
    std::istringstream text(scene::tum_text(trajectory));
    auto const again = scene::read_tum(text, "again", 100);
    bool const matrices = trajectory.format == scene::TrajectoryFormat::kitti || trajectory.format == scene::TrajectoryFormat::replica;
    require(again.size() == trajectory.size(), "every pose is read back");
    for (std::size_t i = 0; i < again.size(); ++i) {
        auto const &a = again[i].pose, &b = trajectory[i].pose;
        require(again[i].seconds == trajectory[i].seconds && a.position == b.position, "stamps and places are read back");
        for (int k = 0; k < 3; ++k)
            require(glm::length(a.rotation[k] - b.rotation[k]) <= (matrices ? 4e-3 : 1e-14), "rotations are read back");
    }
}

/// Any form: poses, or an error of one line.
void try_any_form(std::string const& text)
{
    std::istringstream stream(text);
    scene::Trajectory trajectory;
    try {
        trajectory = scene::read_trajectory(stream, "file", 100);
    } catch (Error const& error) {
        return require_error(error.what());
    }
    require(!trajectory.empty() && trajectory.size() <= 100, "there are poses, and no more than asked for");
    for (auto const& stamped : trajectory) require_pose(stamped, 1.001e-3);
    require_notes(trajectory, 8);
    require_written(trajectory);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    std::string const text(reinterpret_cast<char const*>(data), size);
    try_any_form(text);
    std::istringstream stream(text);
    scene::Trajectory trajectory;
    try {
        trajectory = scene::read_tum(stream, "file", 100);
    } catch (Error const& error) {
        require_error(error.what());
        return 0;
    }
    require(!trajectory.empty() && trajectory.size() <= 100, "there are poses, and no more than asked for");
    require(trajectory.far_from_unit <= trajectory.size(), "each quaternion counts once");
    for (auto const& stamped : trajectory) require_camera(stamped);
    require_notes(trajectory, 5);
    require_written(trajectory);

    auto const start = scene::look_at({1.0, 2.0, 3.0}, {-4.0, 0.0, 9.0});
    auto const moved = scene::relative_to_first(trajectory, start);
    require(moved.size() == trajectory.size(), "motion keeps every pose");
    require(moved[0].pose.rotation == start.rotation && moved[0].pose.position == start.position, "motion begins at the start");
    for (auto const& stamped : moved) require_camera(stamped);
    return 0;
}
