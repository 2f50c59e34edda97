#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <tilemesh/track/normal_equations.hpp>
#include <tilemesh/track/small_system.hpp>

namespace tilemesh { inline namespace v0_2 { namespace track {

TILEMESH_HOST bool is_usable(NormalEquations const& e) noexcept
{
    if ((e.unknowns != 6 && e.unknowns != 8) || e.pixels == 0 || !std::isfinite(e.cost) || e.cost < 0.0) return false;
    double largest = 0.0;
    for (std::uint32_t i = 0; i < e.unknowns; ++i) {
        if (!std::isfinite(e.g[i]) || !(e.h[i][i] >= 0.0)) return false;
        for (std::uint32_t j = 0; j < e.unknowns; ++j)
            if (!std::isfinite(e.h[i][j])) return false;
        largest = std::max(largest, e.h[i][i]);
    }
    return largest > 0.0;
}

TILEMESH_HOST std::optional<std::array<double, 8>> solve_damped(NormalEquations const& e, double lambda)
{
    if (!is_usable(e)) return {};
    std::size_t const n = e.unknowns;
    // Scaled to a diagonal of 1, rotations and translations are alike, and Marquardt's term is lambda.
    double scale[8]{}, a[8][8]{}, y[8]{};
    for (std::size_t i = 0; i < n; ++i) scale[i] = e.h[i][i] > 0.0 ? 1.0 / std::sqrt(e.h[i][i]) : 0.0;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j <= i; ++j) {
            double value = i == j ? 1.0 + lambda : e.h[i][j] * scale[i] * scale[j];
            for (std::size_t k = 0; k < j; ++k) value -= a[i][k] * a[j][k];
            // A pivot at the level of rounding, 64 steps of double, says nothing about the direction.
            if (i == j && !(value > 64 * 2.2e-16)) return {};
            a[i][j] = i == j ? std::sqrt(value) : value / a[j][j];
        }
    for (std::size_t i = 0; i < n; ++i) {
        y[i] = -e.g[i] * scale[i];
        for (std::size_t k = 0; k < i; ++k) y[i] -= a[i][k] * y[k];
        y[i] /= a[i][i];
    }
    std::array<double, 8> x{};
    for (std::size_t i = n; i-- > 0;) {
        x[i] = y[i];
        for (std::size_t k = i + 1; k < n; ++k) x[i] -= a[k][i] * x[k];
        x[i] /= a[i][i];
    }
    for (std::size_t i = 0; i < n; ++i)
        if (!std::isfinite(x[i] *= scale[i])) return {};
    return x;
}

}}} // namespace tilemesh::track
