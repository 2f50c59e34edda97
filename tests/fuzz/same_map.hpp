#pragma once
#include "plain_ply.hpp"
#include "require.hpp"
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tilemesh/scene/map.hpp>

/// Equal except for rounding to float.
inline bool near_to(float value, double expected)
{
    return std::fabs(static_cast<double>(value) - expected) <= 2e-7 * std::fabs(expected) + 1e-44;
}

inline void require_same(tilemesh::scene::Map const& map, plain::Map const& expected)
{
    require(map.gaussians.size() == expected.gaussians.size() && map.rejected == expected.rejected,
            "rows are kept and rejected as by the plain reader");
    require(map.sh_degree == expected.degree, "the degree is that of the plain reader");
    std::size_t at = 0;
    for (std::size_t i = 0; i < map.gaussians.size(); ++i) {
        auto const& g = map.gaussians[i];
        auto const& e = expected.gaussians[i];
        bool same = static_cast<std::uint64_t>(g.id) == e.id;
        for (unsigned k = 0; k < 3; ++k) {
            // If a colour cancels, it is off by a rounding of its terms.
            bool const colour = std::fabs(static_cast<double>(g.colour[k]) - e.values[3 + k]) <= 2e-7 * std::fmax(std::fabs(e.values[3 + k]), 1e-8);
            same = same && near_to(g.mean_world[k], e.values[k]) && colour && near_to(g.log_scale[k], e.values[7 + k]);
        }
        for (unsigned k = 0; k < 4; ++k) same = same && near_to(g.rotation[k], e.values[10 + k]);
        require(same && near_to(g.opacity, e.values[6]), "a Gaussian is as the plain reader reads it");
        for (double const value : e.harmonics)
            require(near_to(map.harmonics[at++], value), "harmonics are as the plain reader reads them");
    }
}

