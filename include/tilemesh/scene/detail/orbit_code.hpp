#pragma once
#include <cmath>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/scene/orbit.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene {

TILEMESH_HOST std::vector<splat::Camera> orbit(splat::Camera const& start, glm::dvec3 target_world,
                                               double degrees_per_frame, std::uint32_t frames, glm::dvec3 up)
{
    if (!(std::fabs(degrees_per_frame) <= most_orbit_degrees))
        throw Error("an orbit of " + number_text(degrees_per_frame) + " degrees a frame cannot be rendered (its angles are not known to a part of a "
                    "degree); give at most 1e9 degrees");
    glm::dmat3 const to_upright = upright(up);
    std::vector<splat::Camera> cameras;
    cameras.reserve(frames);
    Pose const pose = pose_of(start);
    Intrinsics const lens = lens_of(start);
    for (std::uint32_t k = 0; k < frames; ++k) {
        if (k == 0) {
            cameras.push_back(start);
            continue;
        }
        // Whole turns are subtracted first, because the sine of a large angle loses digits.
        constexpr double radians = 3.14159265358979323846 / 180.0;
        double const angle = std::fmod(k * std::fmod(degrees_per_frame, 360.0), 360.0) * radians;
        double const c = std::cos(angle), s = std::sin(angle);
        glm::dmat3 const turn{c, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, c};
        glm::dmat3 const turn_world = glm::transpose(to_upright) * turn * to_upright;
        cameras.push_back(
            make_camera({pose.rotation * glm::transpose(turn_world), target_world + turn_world * (pose.position - target_world)}, lens));
    }
    return cameras;
}

}}} // namespace tilemesh::scene
