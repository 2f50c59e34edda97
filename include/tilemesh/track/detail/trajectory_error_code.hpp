#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/pose_update.hpp>
#include <tilemesh/track/small_system.hpp>
#include <tilemesh/track/trajectory_error.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace track {

TILEMESH_HOST RigidMotion align(std::span<glm::dvec3 const> from, std::span<glm::dvec3 const> to)
{
    if (from.empty()) return {};
    glm::dvec3 from_centre{0.0}, to_centre{0.0};
    for (std::size_t i = 0; i < from.size(); ++i) from_centre += from[i], to_centre += to[i];
    from_centre /= static_cast<double>(from.size());
    to_centre /= static_cast<double>(from.size());
    double s[3][3]{};
    for (std::size_t i = 0; i < from.size(); ++i)
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) s[a][b] += (from[i][a] - from_centre[a]) * (to[i][b] - to_centre[b]);
    SquareMatrix<4> const horn{{{s[0][0] + s[1][1] + s[2][2], s[1][2] - s[2][1], s[2][0] - s[0][2], s[0][1] - s[1][0]},
                                {s[1][2] - s[2][1], s[0][0] - s[1][1] - s[2][2], s[0][1] + s[1][0], s[2][0] + s[0][2]},
                                {s[2][0] - s[0][2], s[0][1] + s[1][0], -s[0][0] + s[1][1] - s[2][2], s[1][2] + s[2][1]},
                                {s[0][1] - s[1][0], s[2][0] + s[0][2], s[1][2] + s[2][1], -s[0][0] - s[1][1] + s[2][2]}}};
    auto const q = eigen_of(horn).vectors[3];
    RigidMotion out{scene::rotation_matrix(q[0], q[1], q[2], q[3])};
    out.translation = to_centre - out.rotation * from_centre;
    return out;
}

TILEMESH_HOST ErrorSummary summary_of(std::span<double const> errors)
{
    ErrorSummary out;
    for (double const e : errors) {
        out.rmse += e * e;
        out.mean += e;
        out.largest = std::max(out.largest, e);
    }
    if (errors.empty()) return out;
    out.mean /= static_cast<double>(errors.size());
    out.rmse = std::sqrt(out.rmse / static_cast<double>(errors.size()));
    return out;
}

namespace detail {

TILEMESH_HOST double degrees_of(glm::dmat3 const& rotation)
{
    return glm::length(rotation_vector(rotation)) * 180.0 / 3.14159265358979323846;
}

} // namespace detail

TILEMESH_HOST TrajectoryErrors trajectory_errors(std::span<scene::Pose const> estimated, std::span<scene::Pose const> truth)
{
    if (estimated.size() != truth.size() || truth.empty())
        throw Error("two trajectories cannot be compared (they have " + std::to_string(estimated.size()) + " and " + std::to_string(truth.size()) +
                    " poses); give one estimate for each pose, and at least one");
    std::vector<glm::dvec3> from, to;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        from.push_back(estimated[i].position);
        to.push_back(truth[i].position);
    }
    TrajectoryErrors out;
    out.poses = truth.size();
    out.alignment = align(from, to);
    std::vector<double> plain, aligned, turned, steps, step_turns;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        plain.push_back(glm::length(from[i] - to[i]));
        aligned.push_back(glm::length(out.alignment.rotation * from[i] + out.alignment.translation - to[i]));
        turned.push_back(detail::degrees_of(estimated[i].rotation * glm::transpose(truth[i].rotation)));
        if (i == 0) continue;
        // The step of camera i - 1, camera to camera: a rotation, and a translation in the axes of camera i - 1.
        auto const step = [i](std::span<scene::Pose const> poses) {
            return RigidMotion{poses[i - 1].rotation * glm::transpose(poses[i].rotation),
                               poses[i - 1].rotation * (poses[i].position - poses[i - 1].position)};
        };
        auto const a = step(estimated), b = step(truth);
        steps.push_back(glm::length(a.translation - b.translation));
        step_turns.push_back(detail::degrees_of(glm::transpose(b.rotation) * a.rotation));
    }
    out.ate = summary_of(plain);
    out.ate_aligned = summary_of(aligned);
    out.rotation_deg = summary_of(turned);
    out.rpe = summary_of(steps);
    out.rpe_deg = summary_of(step_turns);
    return out;
}

}}} // namespace tilemesh::track
