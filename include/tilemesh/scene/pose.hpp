#pragma once
#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/splat/camera.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// The size of a picture in pixels.
struct Size {
    std::uint32_t width, height;
};

/// The lens of a camera, its focal lengths and its centre in double precision. fx, fy, cx, cy are in pixels (OpenCV: pixel (0, 0) has its centre
/// at (0.5, 0.5)); `near_depth` is in world units.
struct Intrinsics {
    double fx, fy, cx, cy;
    float near_depth;
    std::uint32_t width, height;
    splat::Lens bend{};
    splat::Shutter shutter{};
};

/// The position and orientation of a camera, in double precision. A world point p has the camera coordinates `rotation * (p - position)`
/// (OpenCV: x right, y down, z forward). `rotation` is world to camera and orthonormal; `position` is the camera centre in the world.
struct Pose {
    glm::dmat3 rotation{1.0};
    glm::dvec3 position{0.0};
};

/// The rotation matrix of the quaternion w, x, y, z, which may have any finite length. For length 0 the result is the identity. The largest
/// component is scaled to 1 first, so that tiny quaternions do not vanish and huge ones do not overflow.
TILEMESH_HOST glm::dmat3 rotation_matrix(double w, double x, double y, double z);

/// The quaternion w, x, y, z of a rotation matrix, of length 1 and with w >= 0. It takes the root of the largest of the four squares
/// (Shepperd 1978), so that no component is a quotient of rounding errors. The matrix must be orthonormal.
TILEMESH_HOST std::array<double, 4> quaternion_of(glm::dmat3 const& r);

/// Makes the camera that every tile holds. Each number is rounded to float once, here.
TILEMESH_HOST splat::Camera make_camera(Pose const& pose, Intrinsics const& lens);

/// The exact pose of a camera: `make_camera(pose_of(c), lens_of(c))` has the bits of c.
TILEMESH_HOST Pose pose_of(splat::Camera const& camera);

/// The exact lens of a camera.
TILEMESH_HOST Intrinsics lens_of(splat::Camera const& camera);

/// The pose at `eye` that looks at `target`. Its y axis is as close to `down` as possible (OpenCV: y points down; the default `down` is the
/// world's y). Throws `Error` if `target` is `eye`. If `down` lies along the line of sight, another axis replaces it.
TILEMESH_HOST Pose look_at(glm::dvec3 eye, glm::dvec3 target, glm::dvec3 down = {0.0, 1.0, 0.0});

/// The rotation from the world to axes of which y points down, against `up`. The z axis is as close to the world's z as possible, or to its y
/// if `up` is along z. The identity for the default of this library, an `up` of (0, -1, 0). Throws `Error` for an `up` of length 0.
TILEMESH_HOST glm::dmat3 upright(glm::dvec3 up);

namespace detail {
TILEMESH_HOST void require_pixels(std::uint32_t width, std::uint32_t height);

/// Says why a matrix is no rotation; empty if it is one.
TILEMESH_HOST std::string fault_of_rotation(glm::dmat3 const& rotation);

/// Says why no camera with this pose and lens can be rendered; empty if it can be rendered. Requires sides from 1 to 65535.
TILEMESH_HOST std::string fault_of(Pose const& pose, Intrinsics const& lens);
TILEMESH_HOST std::string fault_of_lens(Intrinsics const& lens);
} // namespace detail

/// Throws `Error` for a camera that no frame can be rendered with: a number that is not finite, a rotation that is mirrored or not
/// orthonormal within 1e-3, a focal length below a thousandth of the picture's side or above 2^24 pixels, a centre more than 2^24 pixels
/// away, a near plane that is not positive, a lens with a coefficient that is not finite or above 1e6, an omega outside (0, 3], a lens that
/// folds within the picture, and a shutter with a number that is not finite or in whose time the camera turns by more than 1 radian
/// on either side of the centre. Requires sides from 1 to 65535.
TILEMESH_HOST void check_camera(splat::Camera const& camera);
/// Throws `Error` for a camera whose lens bends the picture, and for a rolling shutter. `who`: what knows pinholes alone, as "a derivative".
TILEMESH_HOST void check_pinhole(splat::Camera const& camera, char const* who);
/// Throws `Error` for a panorama. `who`: what draws conics or derives them, as "a derivative".
TILEMESH_HOST void check_no_panorama(splat::Camera const& camera, char const* who);
/// Throws `Error` for a rolling shutter. `who`: what takes a picture as seen at once, as "an insertion".
TILEMESH_HOST void check_no_shutter(splat::Camera const& camera, char const* who);

/// The rolling shutter of a camera with this lens that goes from one pose to another, at constant velocities of turn and of place, in `share` of the
/// time in which it reads its rows, from the top: 1 for the poses at the picture's top and bottom edges. With time stamps it is their difference
/// over the time of reading. `at`: the camera's pose, that of the row of its centre.
TILEMESH_HOST splat::Shutter rolling_shutter(Pose const& from, Pose const& to, double share, Intrinsics const& lens, Pose const& at);
/// The camera that has one pose when it reads the picture's top edge, and the other at the bottom edge.
TILEMESH_HOST splat::Camera rolling_camera(Pose const& first, Pose const& last, Intrinsics lens);

/// A centred lens with square pixels that spans `degrees` from the left to the right border of the picture. Throws `Error` for an angle
/// outside (0, 180) or a side outside 1..65535.
TILEMESH_HOST Intrinsics lens_from_field_of_view(double degrees, Size size, float near_depth = 0.2f);

/// The same view in another size. The horizontal field of view stays, so fx, fy and cx scale by the ratio of the widths. cy keeps its share
/// of the height, and the vertical field of view follows from the new shape. If the size does not change, the camera keeps its bits. Throws
/// `Error` for a side outside 1..65535.
TILEMESH_HOST splat::Camera resized(splat::Camera camera, std::uint32_t width, std::uint32_t height);

/// The camera of a photograph after the photograph is resized: the whole view in other pixels. fx and cx scale by the ratio of the widths,
/// fy and cy by that of the heights, so that both fields of view stay. If the size does not change, the camera keeps its bits. Throws
/// `Error` for a side outside 1..65535.
TILEMESH_HOST splat::Camera stretched(splat::Camera camera, Size size);

/// The size that trainers give a photograph that they reduce: each side divided by `factor` and rounded, a half to the even number; at
/// least 1.
TILEMESH_HOST Size reduced(Size size, std::uint32_t factor);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/pose_code.hpp>
#endif
