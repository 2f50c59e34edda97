#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <string>
#include <tilemesh/track/normal_equations.hpp>
#include <tilemesh/track/pose_accuracy.hpp>
#include <tilemesh/track/small_system.hpp>

namespace tilemesh { inline namespace v0_2 { namespace track {

TILEMESH_HOST PoseAccuracy accuracy_of(NormalEquations const& e, double focal_px, double rows_per_pixel, WeakLimits const& limits)
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

TILEMESH_HOST std::string weak_motions(PoseAccuracy const& accuracy)
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
