#pragma once
#include "machines.hpp"
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/projection.hpp>
#include <vector>

namespace paper {

/// The sphere around the box of all means, including outliers. The authors' experiments place their cameras by it.
struct Ball {
    glm::dvec3 centre{0.0};
    double radius = 0;
};
Ball ball_of(scene::Map const&);

/// The authors' camera for experiments without a recorded path (from their public code). It looks from +z at the centre of the ball, from
/// `radii` radii away. The world's y is up and the vertical field of view is 60 degrees, so that at 2 radii the ball just fits.
scene::Intrinsics authors_lens();
splat::Camera authors_camera(Ball const&, double radii);

/// The tiling of a frame on the paper's grid.
splat::Tiling tiling_of(splat::Camera const&);
inline std::uint32_t index_of(tilemesh::TileId t) noexcept
{
    return t.y() * grid_columns + t.x();
}
/// Hops from one tile to another: along the column and along the row.
std::uint32_t hops_between(std::uint32_t tile, std::uint32_t other);

/// The first and the last tile that a visible splat touches, along x and y.
struct Touched {
    std::uint32_t x0, x1, y0, y1;
};
Touched touched_by(splat::Splat const&, splat::Tiling const&);
/// Calls f with the index of each of these tiles.
template <class F>
void for_each_tile(splat::Splat const& splat, splat::Tiling const& tiling, F const& f)
{
    auto const t = touched_by(splat, tiling);
    for (auto y = t.y0; y <= t.y1; ++y)
        for (auto x = t.x0; x <= t.x1; ++x) f(y * grid_columns + x);
}

/// A picture with one number per tile, 8 pixels a side, in the colours of report/heat_image.hpp: 0 is dark blue; `most` and more is yellow.
report::Image heat_map(std::vector<std::uint32_t> const& of_tiles, std::uint32_t most);

} // namespace paper
