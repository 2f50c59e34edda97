#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/track/normal_equations.hpp>
#include <tilemesh/track/small_system.hpp>

namespace tilemesh { inline namespace v0_2 { namespace track {

/// How well one evaluation determines a pose: the inverse of J^T J, scaled by the variance that the residuals show.
struct PoseAccuracy {
    /// Of rho in units of S and phi in radians, with the exposure as free unknowns. Entries of directions that nothing determines are
    /// large and finite.
    Matrix6 covariance{};
    /// The standard deviation of the least certain motion, in pixels of picture motion.
    double worst_px = 0.0;
    /// The smallest eigenvalue of J^T J over the largest. Near 0, one motion changes nothing in the picture.
    double conditioning = 0.0;
    /// How much each of the six unknowns takes part in the weak motions, from 0 to 1: the diagonal of the projection onto them. 0 if no
    /// motion is weak.
    std::array<double, 6> weak{};

    /// How many of the six independent motions are weak.
    int weak_count() const noexcept { return static_cast<int>(std::lround(std::accumulate(weak.begin(), weak.end(), 0.0))); }
    bool is_weak() const noexcept { return *std::max_element(weak.begin(), weak.end()) > 0.0; }
};

/// When a motion counts as weak.
struct WeakLimits {
    double worst_px = 0.5;     ///< its standard deviation is above this; half a pixel is the basin of forward mode at full resolution
    double conditioning = 1e-6; ///< its eigenvalue is below this share of the largest: ten times the rounding of sums with 24 bits
};

/// The accuracy of the pose of an evaluation, which must be usable. `focal_px` is the focal length: a unit of each unknown moves the picture
/// by about as many pixels. `rows_per_pixel` is the number of residuals that a counted pixel has: 3 for colour, 4 with depth. Rows are taken
/// as independent, with one variance: neighbouring pixels that share a splat are not, so the covariance is too small rather than too large.
TILEMESH_HOST PoseAccuracy accuracy_of(NormalEquations const& e, double focal_px, double rows_per_pixel,
                                       WeakLimits const& limits = {});

/// The weak motions in words, such as "along the view" or "sideways and in yaw"; empty if none is weak. A motion is named if it takes part
/// at least half as much as the motion that takes part most.
TILEMESH_HOST std::string weak_motions(PoseAccuracy const& accuracy);

}}} // namespace tilemesh::track

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/track/detail/pose_accuracy_code.hpp>
#endif
