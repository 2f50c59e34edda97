#pragma once
#include <tilemesh/scene/records.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene {

TILEMESH_HOST void require_harmonics(Map const& map)
{
    // The records and the kernels have harmonics up to degree 3, and larger degrees overflow the number of coefficients.
    if (map.sh_degree > 3)
        throw Error("a map with view-dependent colour of degree " + std::to_string(map.sh_degree) +
                    " (0 to 3 are the degrees of 3D Gaussian Splatting); fill in degree 3 at most");
    std::size_t const floats = 3 * std::size_t{splat::harmonics_per_channel(map.sh_degree)};
    if (map.harmonics.size() != map.gaussians.size() * floats)
        throw Error("a map with " + std::to_string(map.harmonics.size()) + " coefficients of harmonics (" +
                    std::to_string(map.gaussians.size()) + " Gaussians of degree " + std::to_string(map.sh_degree) + " have " +
                    std::to_string(map.gaussians.size() * floats) + "); fill in all of them");
}

TILEMESH_HOST Map at_degree(Map map, std::uint32_t degree)
{
    require_harmonics(map);
    if (degree >= map.sh_degree) return map;
    std::size_t const from = 3 * splat::harmonics_per_channel(map.sh_degree), to = 3 * splat::harmonics_per_channel(degree);
    for (std::size_t i = 0; i < map.gaussians.size(); ++i) {
        auto const row = map.harmonics.begin() + static_cast<std::ptrdiff_t>(i * from);
        if (i != 0) std::copy_n(row, to, map.harmonics.begin() + static_cast<std::ptrdiff_t>(i * to));
        if (degree == 0)
            for (float& c : map.gaussians[i].colour) c = std::max(c, 0.0f);
    }
    map.harmonics.resize(map.gaussians.size() * to);
    map.sh_degree = degree;
    return map;
}

}}} // namespace tilemesh::scene
