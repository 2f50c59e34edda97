#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <tilemesh/config.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// The median of the means along each axis; every Gaussian counts once. Far outliers do not move it unless they are half of the map. For an
/// even number of Gaussians it is the upper of the two middle values; for an empty map it is the origin. `AnyMap` is Map, or another type whose
/// `gaussians` have a `mean_world`.
template <class AnyMap = Map>
glm::dvec3 robust_centre(AnyMap const& map)
{
    glm::dvec3 centre{0.0};
    if (map.gaussians.empty()) return centre;
    std::vector<float> values(map.gaussians.size());
    for (int axis = 0; axis < 3; ++axis) {
        std::transform(map.gaussians.begin(), map.gaussians.end(), values.begin(), [&](auto const& g) { return g.mean_world[axis]; });
        auto const middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::nth_element(values.begin(), middle, values.end());
        centre[axis] = static_cast<double>(*middle);
    }
    return centre;
}

/// The most degrees a frame: a double still has a ten-millionth of a degree there.
inline constexpr double most_orbit_degrees = 1e9;

/// Returns `frames` cameras on a circle about the vertical axis through `target_world`, which is along `up`. Frame 0 is `start`, bit for bit.
/// Frame k is `start` rotated about the axis by k * `degrees_per_frame`, computed from k alone, so that no error accumulates. A positive
/// angle moves a camera that faces the axis to its own left, as in the recorded orbits of the paper's maps.
/// Throws `Error` for more than `most_orbit_degrees` in either direction.
TILEMESH_HOST std::vector<splat::Camera> orbit(splat::Camera const& start, glm::dvec3 target_world, double degrees_per_frame, std::uint32_t frames,
                                               glm::dvec3 up = {0.0, -1.0, 0.0});

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/orbit_code.hpp>
#endif
