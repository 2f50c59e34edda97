#pragma once
#include <array>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/pose_update.hpp>
#include <tilemesh/track/small_system.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace track {

/// A rigid motion of the world: p goes to rotation * p + translation.
struct RigidMotion {
    glm::dmat3 rotation{1.0};
    glm::dvec3 translation{0.0};
};

/// The rigid motion that brings the points `from` closest to the points `to`, in the sum of squares (Umeyama 1991 without scale). The
/// rotation is the quaternion of the largest eigenvalue of Horn's matrix (1987), which is the same optimum and never a reflection. Points on
/// one line leave a turn about it free; then any optimum is returned. Requires equally many points.
TILEMESH_HOST RigidMotion align(std::span<glm::dvec3 const> from, std::span<glm::dvec3 const> to);

/// A series of errors in numbers: the root of the mean square, the mean and the largest.
struct ErrorSummary {
    double rmse = 0.0, mean = 0.0, largest = 0.0;
};

TILEMESH_HOST ErrorSummary summary_of(std::span<double const> errors);

/// The errors of a trajectory against the truth, as the program evo computes them (Grupp 2017). Translations are in world units.
struct TrajectoryErrors {
    /// Absolute: the distance of the camera centres pose by pose (`evo_ape`), and after the alignment (`evo_ape --align`).
    ErrorSummary ate, ate_aligned;
    /// Absolute, without alignment: the angle between the rotations, in degrees (`evo_ape --pose_relation angle_deg`).
    ErrorSummary rotation_deg;
    /// Relative, from each pose to the next: the error of the step's translation in the camera's axes (`evo_rpe --delta 1 --delta_unit f`),
    /// and of its rotation in degrees (with `--pose_relation angle_deg`).
    ErrorSummary rpe, rpe_deg;
    std::size_t poses = 0; ///< that were compared; the relative errors are of one step less
    RigidMotion alignment; ///< of the estimate to the truth
};

namespace detail {
/// The angle of a rotation in degrees, exact near 0.
TILEMESH_HOST double degrees_of(glm::dmat3 const& rotation);
} // namespace detail

/// Compares pose i with pose i; the caller associates them, for example by time. Throws `Error` for different numbers of poses and for none.
/// With one pose, the relative errors are 0.
TILEMESH_HOST TrajectoryErrors trajectory_errors(std::span<scene::Pose const> estimated,
                                                 std::span<scene::Pose const> truth);

}}} // namespace tilemesh::track

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/track/detail/trajectory_error_code.hpp>
#endif
