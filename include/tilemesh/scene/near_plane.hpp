#pragma once
#include <algorithm>
#include <cstddef>
#include <limits>
#include <tilemesh/scene/named_camera.hpp>
#include <tilemesh/splat/lens_point.hpp>
#include <tilemesh/splat/view.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

namespace detail {
/// At most so many records decide about a near plane: every k-th row of the map. The median of 4,096 depths is good to some percent.
inline constexpr std::size_t near_plane_sample = 4096;
/// A tenth of the median depth if that is below `default_near`; `default_near` if there is no depth.
inline float near_of_depths(std::vector<float> depths)
{
    if (depths.empty()) return default_near;
    auto const middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
    std::nth_element(depths.begin(), middle, depths.end());
    return std::clamp(0.1f * *middle, std::numeric_limits<float>::min(), default_near);
}
} // namespace detail

/// The near plane for a camera whose file names none: 0.2, or a tenth of the median depth of what the picture shows if that is less. So a map
/// in other units, or a camera close to its object, keeps the splats before it, and a room keeps the trainers' plane. The median is that of
/// at most 4,096 rows, evenly spaced, whose means lie in front of the camera and in the picture. It depends on map and camera alone.
///
/// `AnyMap` is Map, or another type whose `gaussians` have a `mean_world`. Cost: one product with the rotation for each row of the sample.
template <class AnyMap>
float near_for(AnyMap const& map, splat::Camera const& camera)
{
    auto const& gaussians = map.gaussians;
    std::size_t const step = gaussians.size() / detail::near_plane_sample + 1;
    std::vector<float> depths;
    auto bounded = camera;
    splat::bound_lens(bounded);
    for (std::size_t row = 0; row < gaussians.size(); row += step) {
        double view[3];
        for (int i = 0; i < 3; ++i) {
            view[i] = 0;
            for (int j = 0; j < 3; ++j)
                view[i] += double{camera.rotation[i][j]} * (double{gaussians[row].mean_world[j]} - double{camera.position[j]});
        }
        auto const seen = splat::through_lens<double>(bounded, view);
        double const x = seen.at[0] + camera.cx, y = seen.at[1] + camera.cy;
        if (seen.seen && x >= 0 && x < camera.width && y >= 0 && y < camera.height) depths.push_back(static_cast<float>(seen.depth));
    }
    return detail::near_of_depths(std::move(depths));
}

/// Gives each camera that names no near plane the one of `near_for`.
template <class AnyMap>
void choose_near(std::vector<NamedCamera>& cameras, AnyMap const& map)
{
    for (auto& each : cameras)
        if (!each.names_near) each.camera.near_depth = near_for(map, each.camera);
}

}}} // namespace tilemesh::scene
