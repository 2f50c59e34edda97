#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/splat/lens.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene {

TILEMESH_HOST glm::dmat3 rotation_matrix(double w, double x, double y, double z)
{
    double const largest = std::fmax(std::fmax(std::fabs(w), std::fabs(x)), std::fmax(std::fabs(y), std::fabs(z)));
    if (!(largest > 0.0)) return glm::dmat3{1.0};
    w /= largest, x /= largest, y /= largest, z /= largest;
    double const s = 2.0 / (w * w + x * x + y * y + z * z);
    // GLM's constructor takes columns.
    return {1.0 - s * (y * y + z * z), s * (x * y + w * z),       s * (x * z - w * y),
            s * (x * y - w * z),       1.0 - s * (x * x + z * z), s * (y * z + w * x),
            s * (x * z + w * y),       s * (y * z - w * x),       1.0 - s * (x * x + y * y)};
}

TILEMESH_HOST std::array<double, 4> quaternion_of(glm::dmat3 const& r)
{
    // Four times the squares; GLM's first index is the column.
    std::array<double, 4> const squares{1.0 + r[0][0] + r[1][1] + r[2][2], 1.0 + r[0][0] - r[1][1] - r[2][2],
                                        1.0 - r[0][0] + r[1][1] - r[2][2], 1.0 - r[0][0] - r[1][1] + r[2][2]};
    auto const largest = static_cast<std::size_t>(std::max_element(squares.begin(), squares.end()) - squares.begin());
    double const wx = r[1][2] - r[2][1], wy = r[2][0] - r[0][2], wz = r[0][1] - r[1][0];
    double const xy = r[0][1] + r[1][0], xz = r[0][2] + r[2][0], yz = r[1][2] + r[2][1];
    std::array<std::array<double, 4>, 4> const products{
        {{squares[0], wx, wy, wz}, {wx, squares[1], xy, xz}, {wy, xy, squares[2], yz}, {wz, xz, yz, squares[3]}}};
    std::array<double, 4> q = products[largest];
    double const length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    double const divisor = q[0] < 0.0 ? -length : length;
    for (double& component : q) component /= divisor;
    return q;
}

TILEMESH_HOST splat::Camera make_camera(Pose const& pose, Intrinsics const& lens)
{
    splat::Camera camera{};
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) camera.rotation[row][column] = static_cast<float>(pose.rotation[column][row]);
        camera.position[row] = static_cast<float>(pose.position[row]);
    }
    camera.fx = static_cast<float>(lens.fx);
    camera.fy = static_cast<float>(lens.fy);
    camera.cx = static_cast<float>(lens.cx);
    camera.cy = static_cast<float>(lens.cy);
    camera.near_depth = lens.near_depth;
    camera.width = lens.width;
    camera.height = lens.height;
    camera.lens = lens.bend;
    camera.shutter = lens.shutter;
    return camera;
}

TILEMESH_HOST Pose pose_of(splat::Camera const& camera)
{
    Pose pose;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) pose.rotation[column][row] = static_cast<double>(camera.rotation[row][column]);
        pose.position[row] = static_cast<double>(camera.position[row]);
    }
    return pose;
}

TILEMESH_HOST Intrinsics lens_of(splat::Camera const& camera)
{
    return {camera.fx, camera.fy, camera.cx, camera.cy, camera.near_depth, camera.width, camera.height, camera.lens, camera.shutter};
}

TILEMESH_HOST Pose look_at(glm::dvec3 eye, glm::dvec3 target, glm::dvec3 down)
{
    double const distance = glm::length(target - eye);
    if (!(distance > 0.0) || !std::isfinite(distance))
        throw Error("a camera cannot look at its own position (eye and target are the same point or not finite); move one of them");
    glm::dvec3 const forward = (target - eye) / distance;

    // Below this sine the cross product is mostly rounding error; the world axis farthest from the line of sight replaces `down`.
    constexpr double parallel = 1e-9;
    glm::dvec3 right = glm::cross(down, forward);
    if (!(glm::length(right) > parallel * glm::length(down))) {
        glm::dvec3 const other = std::fabs(forward.z) < 0.9 ? glm::dvec3{0.0, 0.0, 1.0} : glm::dvec3{0.0, 1.0, 0.0};
        right = glm::cross(other, forward);
    }
    right = glm::normalize(right);
    return {glm::transpose(glm::dmat3{right, glm::cross(forward, right), forward}), eye};
}

TILEMESH_HOST glm::dmat3 upright(glm::dvec3 up)
{
    double const length = glm::length(up);
    if (!(length > 0.0) || !std::isfinite(length)) throw Error("a direction of length 0 is no up (it points nowhere); write for example 0,1,0");
    glm::dvec3 const down = -up / length;
    glm::dvec3 const hint = std::fabs(down.z) > 0.99 ? glm::dvec3{0.0, 1.0, 0.0} : glm::dvec3{0.0, 0.0, 1.0};
    glm::dvec3 const forward = glm::normalize(hint - glm::dot(hint, down) * down);
    return glm::transpose(glm::dmat3{glm::cross(down, forward), down, forward});
}

namespace detail {

TILEMESH_HOST std::string fault_of_rotation(glm::dmat3 const& rotation)
{
    glm::dmat3 const square = glm::transpose(rotation) * rotation;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            if (!(std::fabs(square[column][row] - (row == column ? 1.0 : 0.0)) <= 1e-3)) return "its rotation is not orthonormal within 1e-3";
    if (!(glm::determinant(rotation) > 0.0)) return "its rotation is mirrored, the determinant is -1";
    return "";
}

TILEMESH_HOST std::string fault_of(Pose const& pose, Intrinsics const& lens)
{
    if (auto why = fault_of_rotation(pose.rotation); !why.empty()) return why;
    for (int axis = 0; axis < 3; ++axis)
        if (!std::isfinite(pose.position[axis])) return "its position is not finite";
    // 2^24 pixels: there one step of a direction in float, 2^-24, is as wide as a pixel, and neighbouring pixel coordinates begin to
    // coincide. A thousandth of a side: the picture spans 179.8 degrees.
    constexpr double most_px = 16777216.0, least_share = 1e-3;
    auto const is_share = [](double v) { return std::fabs(v) < 2.0; };
    if (is_share(lens.fx) && is_share(lens.fy) && is_share(lens.cx) && is_share(lens.cy) && lens.width >= 16 && lens.height >= 16 && lens.fx > 0.0 &&
        lens.fy > 0.0)
        return "fx, fy, cx and cy are below 2: they are shares of the picture's sides, and not pixels";
    struct Axis {
        char const *focal_name, *centre_name;
        double focal, centre, side;
    };
    for (auto const& [focal_name, centre_name, focal, centre, side] : {Axis{"fx", "cx", lens.fx, lens.cx, static_cast<double>(lens.width)},
                                                                       Axis{"fy", "cy", lens.fy, lens.cy, static_cast<double>(lens.height)}}) {
        std::string const f = focal_name;
        if (!(focal > 0.0)) return f + " is not positive";
        if (!(focal >= least_share * side)) return f + " is below a thousandth of the picture's side";
        if (!(focal <= most_px)) return f + " is above 2^24 pixels";
        if (!(std::fabs(centre) <= most_px)) return std::string(centre_name) + " is more than 2^24 pixels away";
    }
    if (!(lens.near_depth > 0.0f)) return "near is not positive";
    if (!std::isfinite(lens.near_depth)) return "near is not finite";
    if (auto const& s = lens.shutter; s.rolls()) {
        double turn = 0;
        for (int k = 0; k < 3; ++k) {
            turn += double{s.turn[k]} * s.turn[k];
            if (!(std::fabs(s.move[k]) <= 1e6f)) return "its shutter moves by a length that is not a number within 1e6";
        }
        double const reach = std::fmax(lens.cy, lens.height - lens.cy) / lens.fy;
        if (!(std::sqrt(turn) * reach <= 1.0)) return "it turns by more than 1 radian, or by no number, while half of its rows are read";
    }
    return fault_of_lens(lens);
}

TILEMESH_HOST std::string fault_of_lens(Intrinsics const& lens)
{
    auto const& bend = lens.bend;
    if (bend.kind == splat::LensKind::pinhole || bend.kind == splat::LensKind::equirectangular) return "";
    if (bend.kind > splat::LensKind::equirectangular) return "it has a kind of lens that there is not";
    for (float const v : {bend.k[0], bend.k[1], bend.k[2], bend.k[3], bend.k[4], bend.k[5], bend.p[0], bend.p[1]})
        if (!(std::fabs(v) <= 1e6f)) return "a coefficient of its lens is not a number within 1e6";
    if (bend.kind == splat::LensKind::fov && !(bend.k[0] > 0.0f && bend.k[0] <= 3.0f)) return "omega of its lens is not between 0 and 3 radians";
    // The picture's farthest corner; lenses that see no farther than some angle may leave corners dark, so their nearest side.
    double const across[2] = {lens.cx / lens.fx, (lens.width - lens.cx) / lens.fx}, down[2] = {lens.cy / lens.fy, (lens.height - lens.cy) / lens.fy};
    auto const farther = [](double const (&v)[2]) { return std::max(std::fabs(v[0]), std::fabs(v[1])); };
    bool const angle = bend.kind == splat::LensKind::fisheye, dark = angle || bend.kind == splat::LensKind::fov;
    double const distance = dark ? std::min(farther(across), farther(down)) : std::hypot(farther(across), farther(down));
    auto const reach = splat::reach_of<double>(bend, distance);
    auto const radius = [&](double r) { return (angle ? "an angle of " + std::to_string(r) + " radians" : "a slope of " + std::to_string(r)); };
    if (!(reach.radius < reach.fold)) {
        if (reach.is_fold) return "its lens folds within the picture, at " + radius(reach.fold);
        if (angle) return "its lens sees more than 360 degrees: the picture's nearest side is beyond " + radius(reach.fold);
        return "its lens does not see all of the picture: " + std::string(dark ? "its nearest side" : "a corner") + " is beyond " +
               radius(reach.fold);
    }
    // The tangential part folds a picture, too: from the centre to corners and sides, what is seen must follow.
    for (int i = 0; bend.kind == splat::LensKind::opencv && (bend.p[0] != 0.0f || bend.p[1] != 0.0f) && i < 9; ++i) {
        double const to[2] = {i % 3 == 0 ? -across[0] : i % 3 == 1 ? 0.0 : across[1], i / 3 == 0 ? -down[0] : i / 3 == 1 ? 0.0 : down[1]};
        double x = 0, y = 0, at[2], by[3];
        for (int step = 1; step <= 64; ++step)
            for (int k = 0; k < 4; ++k) { // Newton's method, from the place before
                splat::bend_slopes<double>(bend, x, y, at, by);
                double const e = to[0] * step / 64 - at[0], f = to[1] * step / 64 - at[1], determinant = by[0] * by[2] - by[1] * by[1];
                bool const lost = k == 3 && std::hypot(e, f) > 1e-3;
                if (!(determinant > 0 && by[0] + by[2] > 0) || lost) return "its lens folds within the picture, at " + radius(std::hypot(x, y));
                x += (by[2] * e - by[1] * f) / determinant, y += (by[0] * f - by[1] * e) / determinant;
            }
    }
    return "";
}

TILEMESH_HOST void require_pixels(std::uint32_t width, std::uint32_t height)
{
    // 65,535: the largest 16-bit pixel coordinate, and the limit in camera files.
    if (width == 0 || height == 0 || width > 65535 || height > 65535)
        throw Error("a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                    " pixels cannot be rendered (each side is 1 to 65535); choose another size");
}

} // namespace detail

TILEMESH_HOST void check_camera(splat::Camera const& camera)
{
    detail::require_pixels(camera.width, camera.height);
    if (auto const why = detail::fault_of(pose_of(camera), lens_of(camera)); !why.empty())
        throw Error("a camera that no frame can be rendered with (" + why + "); correct the camera");
}

TILEMESH_HOST void check_no_shutter(splat::Camera const& camera, char const* who)
{
    if (camera.shutter.rolls())
        throw Error(std::string("a camera with a rolling shutter (") + who +
                    " takes a picture as seen at once); leave the shutter out, or take a camera that exposes all rows together");
}

TILEMESH_HOST splat::Shutter rolling_shutter(Pose const& from, Pose const& to, double share, Intrinsics const& lens, Pose const& at)
{
    // A camera's axes turn against the world: of R_to R_from^T the rotation vector is that of the world before the camera.
    auto const q = quaternion_of(to.rotation * glm::transpose(from.rotation));
    double const sine = std::sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]), per_row = lens.fy / lens.height / share; // a focal length of rows
    double const factor = sine > 0.0 ? -2.0 * std::atan2(sine, q[0]) / sine * per_row : 0.0;
    glm::dvec3 const axis = at.rotation * (glm::transpose(from.rotation) * glm::dvec3{q[1], q[2], q[3]});
    glm::dvec3 const move = at.rotation * (to.position - from.position);
    splat::Shutter shutter{};
    for (int k = 0; k < 3; ++k) shutter.turn[k] = static_cast<float>(factor * axis[k]), shutter.move[k] = static_cast<float>(per_row * move[k]);
    return shutter;
}

TILEMESH_HOST splat::Camera rolling_camera(Pose const& first, Pose const& last, Intrinsics lens)
{
    auto const of_first = rolling_shutter(first, last, 1.0, lens, first);
    double const v = lens.cy / lens.fy; // from the first row to that of the centre
    glm::dvec3 const turn = v * glm::dvec3{of_first.turn[0], of_first.turn[1], of_first.turn[2]};
    double const half = 0.5 * glm::length(turn), by = half > 0.0 ? std::sin(half) / (2.0 * half) : 0.0;
    auto const back = glm::transpose(rotation_matrix(std::cos(half), by * turn.x, by * turn.y, by * turn.z));
    Pose const at{back * first.rotation, first.position + lens.cy / lens.height * (last.position - first.position)};
    lens.shutter = rolling_shutter(first, last, 1.0, lens, at);
    return make_camera(at, lens);
}

TILEMESH_HOST void check_pinhole(splat::Camera const& camera, char const* who)
{
    check_no_shutter(camera, who);
    if (camera.lens.kind != splat::LensKind::pinhole)
        throw Error(std::string("a camera with a lens that bends the picture (") + who +
                    " knows pinholes alone); undistort the pictures, and give the pinhole camera that they have then");
}

TILEMESH_HOST void check_no_panorama(splat::Camera const& camera, char const* who)
{
    if (camera.lens.kind == splat::LensKind::equirectangular)
        throw Error(std::string("a panorama (") + who +
                    " takes a Gaussian for a conic, which it is neither at a pole nor on both sides of the seam); render it by exact rays: "
                    "render_map --exact-rays, or splat::Exact");
}

TILEMESH_HOST Intrinsics lens_from_field_of_view(double degrees, Size size, float near_depth)
{
    detail::require_pixels(size.width, size.height);
    if (!(degrees > 0.0 && degrees < 180.0))
        throw Error("a horizontal field of view of " + std::to_string(degrees) +
                    " degrees is no pinhole camera (it lies between 0 and 180); choose another angle");
    constexpr double radians = 3.14159265358979323846 / 180.0;
    double const focal = 0.5 * size.width / std::tan(0.5 * degrees * radians);
    return {focal, focal, 0.5 * size.width, 0.5 * size.height, near_depth, size.width, size.height};
}

TILEMESH_HOST splat::Camera resized(splat::Camera camera, std::uint32_t width, std::uint32_t height)
{
    detail::require_pixels(width, height);
    detail::require_pixels(camera.width, camera.height);
    double const across = static_cast<double>(width) / camera.width;
    double const down = static_cast<double>(height) / camera.height;
    camera.fx = static_cast<float>(across * static_cast<double>(camera.fx));
    camera.fy = static_cast<float>(across * static_cast<double>(camera.fy));
    camera.cx = static_cast<float>(across * static_cast<double>(camera.cx));
    camera.cy = static_cast<float>(down * static_cast<double>(camera.cy));
    camera.width = width;
    camera.height = height;
    camera.lens.limit = 0, camera.lens.ends = 0, camera.shutter.reach = 0; // of another picture
    return camera;
}

TILEMESH_HOST splat::Camera stretched(splat::Camera camera, Size size)
{
    detail::require_pixels(size.width, size.height);
    detail::require_pixels(camera.width, camera.height);
    double const across = static_cast<double>(size.width) / camera.width, down = static_cast<double>(size.height) / camera.height;
    for (auto* const value : {&camera.fx, &camera.cx}) *value = static_cast<float>(across * static_cast<double>(*value));
    for (auto* const value : {&camera.fy, &camera.cy}) *value = static_cast<float>(down * static_cast<double>(*value));
    camera.width = size.width;
    camera.height = size.height;
    camera.lens.limit = 0, camera.lens.ends = 0, camera.shutter.reach = 0;
    return camera;
}

TILEMESH_HOST Size reduced(Size size, std::uint32_t factor)
{
    auto const side = [&](std::uint32_t pixels) {
        std::uint64_t const whole = pixels / factor, twice_rest = 2 * std::uint64_t{pixels % factor};
        bool const up = twice_rest > factor || (twice_rest == factor && whole % 2 != 0);
        return std::max(static_cast<std::uint32_t>(whole + (up ? 1 : 0)), 1u);
    };
    return {side(size.width), side(size.height)};
}

}}} // namespace tilemesh::scene
