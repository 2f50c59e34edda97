#pragma once
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <tilemesh/config.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/camera.hpp>

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
TILEMESH_HOST RotationFactors rotation_factors(double squared_angle);

/// The matrix of the cross product with v.
TILEMESH_HOST glm::dmat3 cross_matrix(glm::dvec3 v);

/// exp(phi): the rotation by |phi| radians about phi (Rodrigues).
TILEMESH_HOST glm::dmat3 rotation_by(glm::dvec3 phi);

/// V(phi), the integral of exp(s phi) for s from 0 to 1: the exponential of (rho, phi) has the translation V(phi) rho.
TILEMESH_HOST glm::dmat3 mean_rotation_by(glm::dvec3 phi);

/// The rotation vector of a rotation, with a length from 0 to pi: the inverse of `rotation_by`. It goes through the quaternion, so small
/// angles keep their digits, and so do angles near pi.
TILEMESH_HOST glm::dvec3 rotation_vector(glm::dmat3 const& rotation);

/// The nearest rotation to a matrix that is one within about 1e-2, by Newton's iteration for the polar decomposition (Higham 1986): each
/// step squares the error, so two steps leave rounding.
TILEMESH_HOST glm::dmat3 orthonormal(glm::dmat3 rotation);

/// The pose after the camera's view moved by `twist`: R <- exp(phi) R and c <- c - R_new^T V(phi) rho, orthonormal again. The form with
/// t = -R c would lose digits far from the origin: a turn would change t by the distance from there.
TILEMESH_HOST scene::Pose moved(scene::Pose const& pose, Twist const& twist);

/// The twist from one pose to another: `moved(from, twist_between(from, to))` is `to`. Rotations of up to pi.
TILEMESH_HOST Twist twist_between(scene::Pose const& from, scene::Pose const& to);

/// Where a camera is after `steps` more steps at constant velocity, if the last step took it from `before` to `last`.
TILEMESH_HOST scene::Pose predicted(scene::Pose const& before, scene::Pose const& last, double steps = 1.0);
/// The same for cameras, by one step, with the lens of `last`. A camera that did not move keeps its bits.
TILEMESH_HOST splat::Camera predicted(splat::Camera const& before, splat::Camera const& last);

}}} // namespace tilemesh::track

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/track/detail/pose_update_code.hpp>
#endif
