#pragma once
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <tilemesh/scene/pose.hpp>

namespace tilemesh { inline namespace v0_2 { namespace track {

/// A small rigid motion in the camera's axes, as an element of se(3). `rho` is in world units, `phi` is a rotation vector in radians. A
/// point of view space moves to exp(phi) p + V(phi) rho, to first order by rho + phi x p.
struct Twist {
    glm::dvec3 rho{0.0}, phi{0.0};
};

/// The factors of exp and V on so(3), for a squared angle: sin t / t, (1 - cos t) / t^2 and (t - sin t) / t^3.
struct RotationFactors {
    double first, second, third;
};

/// Below an angle of 1 all three come from their power series, because t - sin t cancels there. 12 terms leave less than 1e-25.
inline RotationFactors rotation_factors(double squared_angle)
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

/// The matrix of the cross product with v.
inline glm::dmat3 cross_matrix(glm::dvec3 v)
{
    return {0.0, v.z, -v.y, -v.z, 0.0, v.x, v.y, -v.x, 0.0}; // GLM's constructor takes columns
}

/// exp(phi): the rotation by |phi| radians about phi (Rodrigues).
inline glm::dmat3 rotation_by(glm::dvec3 phi)
{
    auto const f = rotation_factors(glm::dot(phi, phi));
    glm::dmat3 const k = cross_matrix(phi);
    return glm::dmat3{1.0} + f.first * k + f.second * (k * k);
}

/// V(phi), the integral of exp(s phi) for s from 0 to 1: the exponential of (rho, phi) has the translation V(phi) rho.
inline glm::dmat3 mean_rotation_by(glm::dvec3 phi)
{
    auto const f = rotation_factors(glm::dot(phi, phi));
    glm::dmat3 const k = cross_matrix(phi);
    return glm::dmat3{1.0} + f.second * k + f.third * (k * k);
}

/// The rotation vector of a rotation, with a length from 0 to pi: the inverse of `rotation_by`. It goes through the quaternion, so small
/// angles keep their digits, and so do angles near pi.
inline glm::dvec3 rotation_vector(glm::dmat3 const& rotation)
{
    auto const q = scene::quaternion_of(rotation);
    glm::dvec3 const axis{q[1], q[2], q[3]};
    double const sine = glm::length(axis);
    return sine > 0.0 ? 2.0 * std::atan2(sine, q[0]) / sine * axis : glm::dvec3{0.0};
}

/// The nearest rotation to a matrix that is one within about 1e-2, by Newton's iteration for the polar decomposition (Higham 1986): each
/// step squares the error, so two steps leave rounding.
inline glm::dmat3 orthonormal(glm::dmat3 rotation)
{
    for (int step = 0; step < 2; ++step) {
        glm::dmat3 const error = glm::transpose(rotation) * rotation - glm::dmat3{1.0};
        rotation = rotation - 0.5 * (rotation * error);
    }
    return rotation;
}

/// The pose after the camera's view moved by `twist`: R <- exp(phi) R and c <- c - R_new^T V(phi) rho, orthonormal again. The form with
/// t = -R c would lose digits far from the origin: a turn would change t by the distance from there.
inline scene::Pose moved(scene::Pose const& pose, Twist const& twist)
{
    glm::dmat3 const rotation = orthonormal(rotation_by(twist.phi) * pose.rotation);
    return {rotation, pose.position - glm::transpose(rotation) * (mean_rotation_by(twist.phi) * twist.rho)};
}

/// The twist from one pose to another: `moved(from, twist_between(from, to))` is `to`. Rotations of up to pi.
inline Twist twist_between(scene::Pose const& from, scene::Pose const& to)
{
    glm::dvec3 const phi = rotation_vector(to.rotation * glm::transpose(from.rotation));
    return {glm::inverse(mean_rotation_by(phi)) * (to.rotation * (from.position - to.position)), phi};
}

/// Where a camera is after `steps` more steps at constant velocity, if the last step took it from `before` to `last`.
inline scene::Pose predicted(scene::Pose const& before, scene::Pose const& last, double steps = 1.0)
{
    Twist const step = twist_between(before, last);
    return moved(last, {steps * step.rho, steps * step.phi});
}

}}} // namespace tilemesh::track
