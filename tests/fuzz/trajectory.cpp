#include "plain_trajectory.hpp"
#include "require.hpp"
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

void require_same(scene::Trajectory const& read, std::vector<plain::Pose> const& expected)
{
    require(read.size() == expected.size(), "as many poses as the plain reader finds");
    for (std::size_t i = 0; i < read.size(); ++i) {
        auto const& e = expected[i];
        require(read[i].seconds == e.seconds, "stamps are those that the plain reader reads");
        for (unsigned row = 0; row < 3; ++row) {
            require(read[i].pose.position[static_cast<int>(row)] == e.position[row], "places are those that the plain reader reads");
            for (unsigned column = 0; column < 3; ++column)
                require(std::fabs(read[i].pose.rotation[static_cast<int>(column)][static_cast<int>(row)] - e.rotation[row][column]) <= 1e-14,
                        "rotations are those that the plain reader reads");
        }
    }
}

std::string form_of(scene::TrajectoryFormat format)
{
    using Format = scene::TrajectoryFormat;
    return format == Format::tum ? "tum" : format == Format::euroc ? "euroc" : format == Format::kitti ? "kitti" : "replica";
}

/// Any form: the form and the poses are those of the plain reader, or there is an error of one line.
void try_any_form(std::string const& text)
{
    bool close = false;
    auto const expected = plain::any_trajectory(text, 100, close);
    try {
        std::istringstream stream(text);
        auto const trajectory = scene::read_trajectory(stream, "file", 100);
        require(close || expected.has_value(), "what the plain reader refuses is refused");
        if (expected) require(form_of(trajectory.format) == expected->form, "the form is that of the plain reader");
        if (expected) require_same(trajectory, expected->poses);
        require(!trajectory.empty() && trajectory.size() <= 100, "there are poses, and no more than asked for");
        for (auto const& stamped : trajectory) require_pose(stamped, 1.001e-3);
        require_notes(trajectory, 8);
    } catch (Error const& error) {
        require(close || !expected, "what the plain reader reads is read");
        require_error(error.what());
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    std::string const text(reinterpret_cast<char const*>(data), size);
    auto const expected = plain::tum(text, 100);
    try_any_form(text);
    try {
        std::istringstream stream(text);
        auto const trajectory = scene::read_tum(stream, "file", 100);
        require(expected.has_value(), "what the plain reader refuses is refused");
        require_same(trajectory, *expected);
        require(!trajectory.empty() && trajectory.size() <= 100, "there are poses, and no more than asked for");
        require(trajectory.far_from_unit <= trajectory.size(), "each quaternion counts once");
        for (auto const& stamped : trajectory) require_camera(stamped);
        require_notes(trajectory, 5);

        auto const start = scene::look_at({1.0, 2.0, 3.0}, {-4.0, 0.0, 9.0});
        auto const moved = scene::relative_to_first(trajectory, start);
        require(moved.size() == trajectory.size(), "motion keeps every pose");
        require(moved[0].pose.rotation == start.rotation && moved[0].pose.position == start.position, "motion begins at the start");
        for (auto const& stamped : moved) require_camera(stamped);
    } catch (Error const& error) {
        require(!expected.has_value(), "what the plain reader reads is read");
        require_error(error.what());
    }
    return 0;
}
