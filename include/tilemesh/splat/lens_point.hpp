#pragma once
#include <cmath>
#include <tilemesh/splat/camera.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// A point of view space in the picture of a camera. `at`: in pixels, from the principal point. `by`: the Jacobian, in pixels per unit of
/// length. `depth`: z, or the distance from a fisheye. `seen` is false, and nothing else has a meaning, if the lens does not see the
/// point; the near plane is left to the caller.
template <class T>
struct LensPoint {
    T at[2], by[2][3], depth;
    bool seen;
};

/// `camera`: of a view, because its lens needs its limit (`bound_lens`). T: float or double. Kernels compute the same in lanes
/// (splat/bend.hpp).
template <class T>
LensPoint<T> through_lens(Camera const& camera, T const (&p)[3]) noexcept
{
    Lens const& lens = camera.lens;
    T const f[2] = {camera.fx, camera.fy}, rho2 = p[0] * p[0] + p[1] * p[1], all = rho2 + p[2] * p[2];
    LensPoint<T> out{};
    if (lens.kind == LensKind::equirectangular) {
        T const flat2 = p[0] * p[0] + p[2] * p[2], flat = std::sqrt(flat2);
        out.depth = std::sqrt(all), out.seen = flat > T(1e-6f) * out.depth; // at a pole there is no azimuth
        if (!out.seen) return out;
        out.at[0] = f[0] * std::atan2(p[0], p[2]), out.at[1] = f[1] * std::atan2(p[1], flat);
        out.by[0][0] = f[0] * p[2] / flat2, out.by[0][2] = -f[0] * p[0] / flat2;
        out.by[1][0] = -f[1] * p[0] * p[1] / (all * flat), out.by[1][1] = f[1] * flat / all, out.by[1][2] = -f[1] * p[2] * p[1] / (all * flat);
        return out;
    }
    if (lens.kind == LensKind::fisheye) {
        T const rho = std::sqrt(rho2), theta = std::atan2(rho, p[2]);
        if (!(theta < T(lens.limit)) || !(all > 0)) return out;
        T distance, slope;
        lens_radius<T>(lens, theta, distance, slope);
        bool const off = rho > T(1e-4f) * std::fabs(p[2]);
        T const g = off ? distance / rho : 1 / p[2], q = off ? (slope * p[2] / all - g) / rho2 : T(0); // of x_i x_j
        for (int i = 0; i < 2; ++i) {
            out.at[i] = f[i] * g * p[i];
            for (int j = 0; j < 2; ++j) out.by[i][j] = f[i] * (q * p[i] * p[j] + (i == j ? g : T(0)));
            out.by[i][2] = -f[i] * slope / all * p[i];
        }
        out.depth = std::sqrt(all), out.seen = true;
        return out;
    }
    if (!(p[2] > 0)) return out;
    T const x = p[0] / p[2], y = p[1] / p[2];
    T at[2] = {x, y}, by[3] = {1, 0, 1}, inner[2] = {x, y}; // the slopes at which the Jacobian is taken
    if (lens.kind != LensKind::pinhole) {
        T const r = std::sqrt(x * x + y * y), most = lens.limit;
        if (lens.ends != 0 && !(r < most)) return out;
        if (r > most) inner[0] = x * most / r, inner[1] = y * most / r;
        bend_slopes<T>(lens, inner[0], inner[1], at, by);
        at[0] += by[0] * (x - inner[0]) + by[1] * (y - inner[1]);
        at[1] += by[1] * (x - inner[0]) + by[2] * (y - inner[1]);
    }
    T const d[2][2] = {{by[0], by[1]}, {by[1], by[2]}};
    for (int i = 0; i < 2; ++i) {
        out.at[i] = f[i] * at[i];
        for (int j = 0; j < 2; ++j) out.by[i][j] = f[i] / p[2] * d[i][j];
        out.by[i][2] = -(out.by[i][0] * inner[0] + out.by[i][1] * inner[1]);
    }
    out.depth = p[2], out.seen = true;
    return out;
}

/// The ray through a place in the picture (pixels, from the principal point), as a direction in view space of any length. False if no
/// direction is seen there. Cost: about 4,000 flops through a lens that bends.
template <class T>
bool ray_of(Camera const& camera, T across, T down, T (&ray)[3]) noexcept
{
    Lens const& lens = camera.lens;
    T const u = across / camera.fx, v = down / camera.fy, distance = std::sqrt(u * u + v * v);
    ray[0] = u, ray[1] = v, ray[2] = 1;
    if (lens.kind == LensKind::pinhole || distance == 0) return true;
    if (lens.kind == LensKind::equirectangular) {
        ray[0] = std::cos(v) * std::sin(u), ray[1] = std::sin(v), ray[2] = std::cos(v) * std::cos(u);
        return std::fabs(u) < T(3.1417f) && std::fabs(v) < T(1.5709f); // pi and pi / 2, with a margin for their rounding
    }
    auto const reach = reach_of<T>(lens, distance);
    if (lens.kind == LensKind::fisheye) {
        if (!(reach.radius < reach.fold && reach.radius < T(lens.limit))) return false;
        T const outward = std::sin(reach.radius) / distance;
        ray[0] = u * outward, ray[1] = v * outward, ray[2] = std::cos(reach.radius);
        return true;
    }
    bool const tangential = lens.kind == LensKind::opencv && (lens.p[0] != 0 || lens.p[1] != 0);
    T const radius = reach.radius < reach.fold ? reach.radius : reach.fold;
    if (radius == reach.fold && !tangential) return false;
    T x = u * radius / distance, y = v * radius / distance, at[2], by[3];
    for (int i = 0; tangential && i < 20; ++i) {
        bend_slopes<T>(lens, x, y, at, by);
        T const e = u - at[0], f = v - at[1], determinant = by[0] * by[2] - by[1] * by[1];
        if (!(determinant > 0)) return false;
        x += (by[2] * e - by[1] * f) / determinant, y += (by[0] * f - by[1] * e) / determinant;
    }
    ray[0] = x, ray[1] = y;
    return lens.ends == 0 || x * x + y * y < T(lens.limit) * T(lens.limit);
}

/// The camera of the row v (Shutter), in the axes of the camera's pose: `turn` takes them to the row's axes, `place` is where it stands.
template <class T>
struct RowPose {
    T turn[3][3], place[3];

    RowPose(Shutter const& s, T v) noexcept
    {
        T const w[3] = {-v * s.turn[0], -v * s.turn[1], -v * s.turn[2]}, angle = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
        T const first = angle > 0 ? std::sin(angle) / angle : T(1), half = angle > 0 ? std::sin(angle / 2) / (angle / 2) : T(1);
        T const second = half * half / 2; // Rodrigues: 1 + first [w] + second [w]^2
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                T const product = i == j ? T(0) : w[3 - i - j] * ((j + 1) % 3 == i ? T(1) : T(-1));
                turn[i][j] = (i == j ? 1 - second * angle * angle : T(0)) + first * product + second * w[i] * w[j];
            }
            place[i] = v * s.move[i];
        }
    }
    /// A point of view space before the row's camera.
    void seen(T const (&p)[3], T (&out)[3]) const noexcept
    {
        for (int i = 0; i < 3; ++i)
            out[i] = turn[i][0] * (p[0] - place[0]) + turn[i][1] * (p[1] - place[1]) + turn[i][2] * (p[2] - place[2]);
    }
};

/// The row on which a point of view space is seen, by three rounds from row 0, as kernels find it. `camera`: of a view.
template <class T>
T row_of_point(Camera const& camera, T const (&p)[3]) noexcept
{
    T v = 0, at[3];
    T const reach = camera.shutter.reach;
    for (int round = 0; round < 3; ++round) {
        RowPose<T>(camera.shutter, v).seen(p, at);
        auto const point = through_lens<T>(camera, at);
        if (!point.seen || !(point.depth > camera.near_depth)) continue;
        T const row = point.at[1] / camera.fy;
        v = row < -reach ? -reach : row > reach ? reach : row;
    }
    return v;
}

/// What the rows' time makes of a picture's Jacobian (2 x 3, in pixels) at a point that the camera of its row sees at `p`.
template <class T>
void shear_by_rows(Camera const& camera, T v, T const (&p)[3], T (&by)[2][3]) noexcept
{
    Shutter const& s = camera.shutter;
    T const move[3] = {s.move[0], s.move[1], s.move[2]}, turn[3] = {s.turn[0], s.turn[1], s.turn[2]};
    auto const& r = RowPose<T>(s, v).turn;
    T w[2] = {0, 0};
    for (int i = 0; i < 3; ++i) {
        int const j = (i + 1) % 3, k = (i + 2) % 3;
        T const motion = p[j] * turn[k] - p[k] * turn[j] - (r[i][0] * move[0] + r[i][1] * move[1] + r[i][2] * move[2]);
        w[0] += by[0][i] * motion / camera.fy, w[1] += by[1][i] * motion / camera.fy;
    }
    for (int i = 0; i < 3; ++i) by[0][i] += w[0] / (1 - w[1]) * by[1][i], by[1][i] /= 1 - w[1];
}

}}} // namespace tilemesh::splat
