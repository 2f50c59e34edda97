#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <string>
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
inline PoseAccuracy accuracy_of(NormalEquations const& e, double focal_px, double rows_per_pixel, WeakLimits const& limits = {})
{
    // Schur's complement: J^T J of the pose after the exposure took its share. A term at rounding level keeps a black picture solvable.
    Matrix6 h{};
    for (std::size_t i = 0; i < 6; ++i)
        for (std::size_t j = 0; j < 6; ++j) h[i][j] = e.h[i][j];
    if (e.unknowns == 8) {
        double const least = 1e-15 * (e.h[6][6] + e.h[7][7]) + 1e-300;
        double const a = e.h[6][6] + least, b = e.h[6][7], d = e.h[7][7] + least, det = std::max(a * d - b * b, 1e-15 * a * d);
        for (std::size_t i = 0; i < 6; ++i)
            for (std::size_t j = 0; j < 6; ++j)
                h[i][j] -= (e.h[i][6] * (d * e.h[6][j] - b * e.h[7][j]) + e.h[i][7] * (a * e.h[7][j] - b * e.h[6][j])) / det;
    }
    auto const eigen = eigen_of(h);
    double const largest = eigen.values[5], floor = 1e-15 * largest;
    double const freedom = std::max(1.0, rows_per_pixel * e.pixels - e.unknowns);
    double const variance = 2.0 * e.cost / freedom;

    PoseAccuracy out;
    out.conditioning = largest > 0.0 ? std::max(0.0, eigen.values[0]) / largest : 0.0;
    for (std::size_t k = 0; k < 6; ++k) {
        double const value = std::max(eigen.values[k], floor);
        double const spread = value > 0.0 ? variance / value : 0.0, px = focal_px * std::sqrt(spread);
        out.worst_px = std::max(out.worst_px, px);
        bool const weak = px > limits.worst_px || !(eigen.values[k] > limits.conditioning * largest);
        for (std::size_t i = 0; i < 6; ++i) {
            if (weak) out.weak[i] += eigen.vectors[k][i] * eigen.vectors[k][i];
            for (std::size_t j = 0; j < 6; ++j) out.covariance[i][j] += spread * eigen.vectors[k][i] * eigen.vectors[k][j];
        }
    }
    return out;
}

/// The weak motions in words, such as "along the view" or "sideways and in yaw"; empty if none is weak. A motion is named if it takes part
/// at least half as much as the motion that takes part most.
inline std::string weak_motions(PoseAccuracy const& accuracy)
{
    static constexpr std::array<char const*, 6> names{"sideways", "vertically", "along the view", "in pitch", "in yaw", "in roll"};
    std::string text;
    double const most = *std::max_element(accuracy.weak.begin(), accuracy.weak.end());
    std::size_t named = 0, last = 0;
    for (std::size_t i = 0; i < 6; ++i)
        if (most > 0.0 && accuracy.weak[i] >= 0.5 * most) ++named, last = i;
    for (std::size_t i = 0; i < 6; ++i) {
        if (!(most > 0.0 && accuracy.weak[i] >= 0.5 * most)) continue;
        if (!text.empty()) text += i == last ? " and " : ", ";
        text += names[i];
    }
    return named == 6 ? "in every direction" : text;
}

}}} // namespace tilemesh::track
