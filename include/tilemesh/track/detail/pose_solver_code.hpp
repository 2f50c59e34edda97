#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/normal_equations.hpp>
#include <tilemesh/track/pose_solver.hpp>
#include <tilemesh/track/pose_update.hpp>
#include <tilemesh/track/small_system.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace track {

TILEMESH_HOST std::vector<Stage> stages_of(Method method, std::uint32_t coarsest)
{
    std::vector<Stage> stages;
    for (std::uint32_t cell = std::max(coarsest, 1u); cell >= 1; cell /= 2) {
        bool const coarse = cell > 1;
        auto const jacobian = method == Method::forward || (method == Method::hybrid && !coarse) ? Jacobian::forward
                              : method == Method::gradient                                      ? Jacobian::gradient
                                                                                                : Jacobian::esm;
        stages.push_back({cell, jacobian, coarse ? 0.25 : 0.01, coarse ? 12u : 30u});
    }
    return stages;
}

namespace detail {

TILEMESH_HOST double mean_cost(NormalEquations const& e) noexcept
{
    return e.cost / e.pixels;
}

TILEMESH_HOST std::optional<std::array<double, 8>> bounded_step(NormalEquations e, double lambda, Exposure const& exposure,
                                                                ExposureLimits const& limits)
{
    std::array<double, 2> const now{exposure.log_gain, exposure.offset}, most{limits.log_gain, limits.offset};
    std::array<double, 8> held{};
    for (;;) {
        auto x = solve_damped(e, lambda);
        if (!x) return {};
        std::size_t beyond = 8;
        for (std::size_t i = 6; i < e.unknowns; ++i)
            if (held[i] == 0.0 && e.h[i][i] > 0.0 && !(std::fabs(now[i - 6] + (*x)[i]) <= most[i - 6])) beyond = i;
        if (beyond == 8) {
            for (std::size_t i = 6; i < 8; ++i) (*x)[i] += held[i];
            return x;
        }
        held[beyond] = std::copysign(most[beyond - 6], now[beyond - 6] + (*x)[beyond]) - now[beyond - 6];
        for (std::size_t i = 0; i < e.unknowns; ++i) e.g[i] += e.h[i][beyond] * held[beyond];
        for (std::size_t i = 0; i < e.unknowns; ++i) e.h[i][beyond] = e.h[beyond][i] = 0.0;
        e.g[beyond] = 0.0;
    }
}

} // namespace detail
}}} // namespace tilemesh::track
