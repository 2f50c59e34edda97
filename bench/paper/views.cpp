#include "views.hpp"
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <tilemesh/report/heat_image.hpp>

namespace paper {

Ball ball_of(scene::Map const& map)
{
    if (map.gaussians.empty()) return {};
    glm::dvec3 low{1e300}, high{-1e300};
    for (auto const& g : map.gaussians)
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], double{g.mean_world[axis]});
            high[axis] = std::max(high[axis], double{g.mean_world[axis]});
        }
    return {0.5 * (low + high), 0.5 * glm::length(high - low)};
}

scene::Intrinsics authors_lens()
{
    double const focal = 360.0 / std::tan(30.0 * 3.14159265358979323846 / 180.0);
    return {focal, focal, 640.0, 360.0, 0.2f, 1280, 720};
}

splat::Camera authors_camera(Ball const& ball, double radii)
{
    auto const eye = ball.centre + glm::dvec3(0.0, 0.0, radii * ball.radius);
    return scene::make_camera(scene::look_at(eye, ball.centre, {0.0, -1.0, 0.0}), authors_lens());
}

splat::Tiling tiling_of(splat::Camera const& camera)
{
    return splat::make_tiling(camera.width, camera.height, (camera.width + grid_columns - 1) / grid_columns,
                              (camera.height + grid_rows - 1) / grid_rows);
}

std::uint32_t hops_between(std::uint32_t tile, std::uint32_t other)
{
    auto const along = [](std::uint32_t a, std::uint32_t b) { return a > b ? a - b : b - a; };
    return along(tile % grid_columns, other % grid_columns) + along(tile / grid_columns, other / grid_columns);
}

Touched touched_by(splat::Splat const& s, splat::Tiling const& tiling)
{
    auto const r = s.rect();
    return {r.x0 / tiling.tile_width, (r.x1 - 1) / tiling.tile_width, r.y0 / tiling.tile_height, (r.y1 - 1) / tiling.tile_height};
}

report::Image heat_map(std::vector<std::uint32_t> const& of_tiles, std::uint32_t most)
{
    constexpr std::uint32_t side = 8;
    std::vector<double> const values(of_tiles.begin(), of_tiles.end());
    return report::heat_image(values, grid_columns, grid_rows, {0, static_cast<double>(most)}, side);
}

} // namespace paper
