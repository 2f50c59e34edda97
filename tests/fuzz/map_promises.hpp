#pragma once
#include "require.hpp"
#include <cmath>
#include <tilemesh/scene/map.hpp>

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
