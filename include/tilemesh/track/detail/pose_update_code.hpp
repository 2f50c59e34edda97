#pragma once
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/pose_update.hpp>

namespace tilemesh { inline namespace v0_2 { namespace track {

TILEMESH_HOST RotationFactors rotation_factors(double squared_angle)
{
    if (squared_angle < 1.0) {
        // Horner's rule: sum of (-t^2)^k / (2k + n)! for n = 1, 2, 3.
        RotationFactors f{1.0, 1.0, 1.0};
        for (int k = 12; k >= 1; --k) {
            double const m = 2.0 * k;
            f.first = 1.0 - squared_angle / (m * (m + 1.0)) * f.first;
            f.second = 1.0 - squared_angle / ((m + 1.0) * (m + 2.0)) * f.second;
            f.third = 1.0 - squared_angle / ((m + 2.0) * (m + 3.0)) * f.third;
        }
        return {f.first, f.second / 2.0, f.third / 6.0};
    }
    double const angle = std::sqrt(squared_angle), half = std::sin(0.5 * angle);
    return {std::sin(angle) / angle, 2.0 * half * half / squared_angle, (angle - std::sin(angle)) / (angle * squared_angle)};
}

TILEMESH_HOST glm::dmat3 cross_matrix(glm::dvec3 v)
{
    return {0.0, v.z, -v.y, -v.z, 0.0, v.x, v.y, -v.x, 0.0}; // GLM's constructor takes columns
}

TILEMESH_HOST glm::dmat3 rotation_by(glm::dvec3 phi)
{
    auto const f = rotation_factors(glm::dot(phi, phi));
    glm::dmat3 const k = cross_matrix(phi);
    return glm::dmat3{1.0} + f.first * k + f.second * (k * k);
}

TILEMESH_HOST glm::dmat3 mean_rotation_by(glm::dvec3 phi)
{
    auto const f = rotation_factors(glm::dot(phi, phi));
    glm::dmat3 const k = cross_matrix(phi);
    return glm::dmat3{1.0} + f.second * k + f.third * (k * k);
}

TILEMESH_HOST glm::dvec3 rotation_vector(glm::dmat3 const& rotation)
{
    auto const q = scene::quaternion_of(rotation);
    glm::dvec3 const axis{q[1], q[2], q[3]};
    double const sine = glm::length(axis);
    return sine > 0.0 ? 2.0 * std::atan2(sine, q[0]) / sine * axis : glm::dvec3{0.0};
}

TILEMESH_HOST glm::dmat3 orthonormal(glm::dmat3 rotation)
{
    for (int step = 0; step < 2; ++step) {
        glm::dmat3 const error = glm::transpose(rotation) * rotation - glm::dmat3{1.0};
        rotation = rotation - 0.5 * (rotation * error);
    }
    return rotation;
}

TILEMESH_HOST scene::Pose moved(scene::Pose const& pose, Twist const& twist)
{
    glm::dmat3 const rotation = orthonormal(rotation_by(twist.phi) * pose.rotation);
    return {rotation, pose.position - glm::transpose(rotation) * (mean_rotation_by(twist.phi) * twist.rho)};
}

TILEMESH_HOST Twist twist_between(scene::Pose const& from, scene::Pose const& to)
{
    glm::dvec3 const phi = rotation_vector(to.rotation * glm::transpose(from.rotation));
    return {glm::inverse(mean_rotation_by(phi)) * (to.rotation * (from.position - to.position)), phi};
}

TILEMESH_HOST scene::Pose predicted(scene::Pose const& before, scene::Pose const& last, double steps)
{
    Twist const step = twist_between(before, last);
    return moved(last, {steps * step.rho, steps * step.phi});
}
TILEMESH_HOST splat::Camera predicted(splat::Camera const& before, splat::Camera const& last)
{
    if (splat::same_view(before, last)) return last;
    return scene::make_camera(predicted(scene::pose_of(before), scene::pose_of(last)), scene::lens_of(last));
}

}}} // namespace tilemesh::track
