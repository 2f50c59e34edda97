#pragma once
#include "plain_ply.hpp"
#include "require.hpp"
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
        for (double const value : e.harmonics) require(near_to(map.harmonics[at++], value), "harmonics are as the plain reader reads them");
    }
}

/// What the readers promise of every map that they read.
inline void require_promises(tilemesh::scene::Map const& map)
{
    for (auto const& note : map.notes) require(is_one_line(note) && note.size() < 2000, "notes are short lines");
    require(map.sh_degree <= 3, "no degree above 3");
    auto const floats = std::size_t{3} * tilemesh::splat::harmonics_per_channel(map.sh_degree);
    require(map.harmonics.size() == map.gaussians.size() * floats, "harmonics go with the Gaussians");
    bool finite = true;
    for (float v : map.harmonics) finite = finite && std::isfinite(v);
    std::uint32_t last = 0;
    for (auto const& g : map.gaussians) {
        require(static_cast<std::uint32_t>(g.id) > last, "ids ascend from 1");
        last = static_cast<std::uint32_t>(g.id);
        float squares = 0.0f;
        for (float q : g.rotation) squares += q * q;
        require(std::fabs(squares - 1.0f) < 1e-5f, "quaternions are normalised");
        for (int i = 0; i < 3; ++i) {
            finite = finite && std::isfinite(g.mean_world[i]) && std::isfinite(g.colour[i]) && std::isfinite(g.log_scale[i]);
            require(map.sh_degree != 0 || g.colour[i] >= 0.0f, "a colour that nothing is added to is not negative");
            require(g.log_scale[i] >= -87.0f, "log_scale is not below -87");
        }
        require(g.opacity >= 0.0f && g.opacity <= 1.0f, "opacity is in [0, 1]");
    }
    require(finite, "numbers are finite");
    require(last <= map.gaussians.size() + map.rejected, "ids are rows");
}
/// A refusal is one short line.
inline void require_short_error(std::string_view text)
{
    require_error(text);
    require(text.size() < 2000, "errors are short");
}
