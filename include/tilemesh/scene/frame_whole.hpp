#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// Returns a camera that shows a map without known cameras. It looks along the world's +z (OpenCV: y down) from the front, with a
/// horizontal field of view of `degrees`. With another `up`, it looks along the z axis of `upright(up)`. It sees the box that holds the middle 90 %
/// of the means along each axis, so far outliers do not count. The near plane is 0.2, or a tenth of the distance to the box if that is less.
///
/// It accepts any map. For an empty map the camera stands one unit before the origin. If all means are one point, the box is three median
/// standard deviations wide. Throws `Error` for a side outside 1..65535, a field of view outside (0, 180) and an `up` of length 0. Cost: one
/// pass over the map per axis. `AnyMap` is Map, or another type whose `gaussians` have a `mean_world` and a `log_scale`.
template <class AnyMap>
splat::Camera frame_whole(AnyMap const& map, Size size, glm::dvec3 up = {0.0, -1.0, 0.0}, double degrees = 60.0)
{
    Intrinsics lens = lens_from_field_of_view(degrees, size);
    glm::dmat3 const to_upright = upright(up), to_world = glm::transpose(to_upright);
    if (map.gaussians.empty()) return make_camera({to_upright, to_world * glm::dvec3{0.0, 0.0, -1.0}}, lens);

    // The middle 90 % of the means along each axis, clamped so that a float has digits left for the distance from there.
    constexpr double far_away = 1e30;
    std::vector<double> values(map.gaussians.size());
    auto const quantile = [&](double share) {
        auto const index = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
        std::nth_element(values.begin(), values.begin() + index, values.end());
        return std::clamp(values[static_cast<std::size_t>(index)], -far_away, far_away);
    };
    glm::dvec3 low{0.0}, high{0.0};
    for (int axis = 0; axis < 3; ++axis) {
        std::transform(map.gaussians.begin(), map.gaussians.end(), values.begin(), [&](auto const& g) {
            glm::dvec3 const mean{g.mean_world[0], g.mean_world[1], g.mean_world[2]};
            return glm::dot(to_world[axis], mean);
        });
        low[axis] = quantile(0.05);
        high[axis] = quantile(0.95);
    }

    // The size of the Gaussians themselves. It matters if the means are one point or a line.
    std::transform(map.gaussians.begin(), map.gaussians.end(), values.begin(), [](auto const& g) {
        float const* s = g.log_scale;
        return std::exp(static_cast<double>(std::max({s[0], s[1], s[2]})));
    });
    double const around = 3.0 * quantile(0.5);

    // A float coordinate of size c cannot tell apart two points closer than 6e-8 c. A hundred such steps are enough for a view.
    glm::dvec3 const centre = 0.5 * (low + high);
    double const coordinate = std::max({std::fabs(centre.x), std::fabs(centre.y), std::fabs(centre.z)});
    double const least = std::max(1e-6, 6e-6 * coordinate);
    double const half_width = std::max(0.5 * (high.x - low.x) + around, least);
    double const half_height = std::max(0.5 * (high.y - low.y) + around, least);

    // Step back from the front of the box until both its sides fit, with a margin of 10 %.
    double const distance = 1.1 * std::max(half_width * lens.fx / (0.5 * size.width), half_height * lens.fy / (0.5 * size.height));
    double const front = low.z - std::min(around, distance);
    lens.near_depth = static_cast<float>(std::min(0.2, 0.1 * distance));
    return make_camera({to_upright, to_world * glm::dvec3{centre.x, centre.y, front - distance}}, lens);
}

}}} // namespace tilemesh::scene
