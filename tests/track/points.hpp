#pragma once
#include "support.hpp"
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/track/normal_equations.hpp>
#include <tilemesh/track/pose_update.hpp>

// An evaluator of poses in double that needs no renderer: points of the world, and where a camera saw them.
namespace track_test {

using namespace tilemesh;

inline constexpr double scale_of_points = 4.0; // S

inline glm::dvec3 in_view(splat::Camera const& camera, glm::dvec3 world)
{
    auto const pose = scene::pose_of(camera);
    return pose.rotation * (world - pose.position);
}

/// Adds a row: derivatives by rho / S and phi, the residual, its Huber limit.
inline void add_row(track::NormalEquations& e, double const (&j)[8], double r, double huber)
{
    double const size = std::fabs(r), w = size <= huber ? 1.0 : huber / size;
    e.cost += size <= huber ? 0.5 * r * r : huber * (size - 0.5 * huber);
    for (std::uint32_t a = 0; a < e.unknowns; ++a) {
        e.g[a] += w * j[a] * r;
        for (std::uint32_t b = 0; b < e.unknowns; ++b) e.h[a][b] += w * j[a] * j[b];
    }
}

/// The reprojection error of points, in pixels: two rows a point. A point behind the camera or outside the picture does not count.
struct Points {
    struct Seen {
        glm::dvec3 world;
        double u, v;
    };
    std::vector<Seen> points;
    double huber = 1e9;
    std::uint32_t calls = 0;

    void see(splat::Camera const& camera, glm::dvec3 world, double du = 0.0, double dv = 0.0)
    {
        auto const p = in_view(camera, world);
        points.push_back({world, camera.fx * p.x / p.z + camera.cx + du, camera.fy * p.y / p.z + camera.cy + dv});
    }
    track::NormalEquations operator()(splat::Camera const& camera, track::Level const&)
    {
        ++calls;
        track::NormalEquations e;
        for (auto const& seen : points) {
            auto const p = in_view(camera, seen.world);
            if (!(p.z > 0.1)) continue;
            double const fx = camera.fx, fy = camera.fy, u = fx * p.x / p.z + camera.cx, v = fy * p.y / p.z + camera.cy;
            if (u < 0 || v < 0 || u > camera.width || v > camera.height) continue;
            ++e.pixels;
            // d(u) for dp = S rho and dp = phi x p.
            glm::dvec3 const du{fx / p.z, 0.0, -fx * p.x / (p.z * p.z)}, dv{0.0, fy / p.z, -fy * p.y / (p.z * p.z)};
            for (int k = 0; k < 2; ++k) {
                glm::dvec3 const by_p = k == 0 ? du : dv, by_phi = glm::cross(p, by_p);
                double const j[8] = {scale_of_points * by_p.x, scale_of_points * by_p.y, scale_of_points * by_p.z, by_phi.x, by_phi.y, by_phi.z, 0, 0};
                add_row(e, j, k == 0 ? u - seen.u : v - seen.v, huber);
            }
        }
        return e;
    }
};

/// Evaluates, and changes the sums: change(sums), or change(sums, camera, level).
template <class Evaluate, class Change>
auto altered(Evaluate& evaluate, Change change)
{
    return [&evaluate, change](splat::Camera const& camera, track::Level const& level) {
        track::NormalEquations e = evaluate(camera, level);
        if constexpr (std::is_invocable_v<Change const&, track::NormalEquations&>) change(e);
        else change(e, camera, level);
        return e;
    };
}

inline scene::Intrinsics lens()
{
    return {500.0, 500.0, 320.0, 240.0, 0.2f, 640, 480};
}

/// The truth as an evaluator sees it: rounded to the camera's floats.
inline splat::Camera true_camera()
{
    return scene::make_camera({track::rotation_by({0.2, -0.4, 0.1}), {0.3, -0.2, 1.0}}, lens());
}

/// The camera turned by so many degrees about a random axis, and moved by `part` of S in a random direction.
inline scene::Pose disturbed(scene::Pose const& pose, double degrees, double part, Random& random, double scale = scale_of_points)
{
    auto out = track::moved(pose, {{}, degrees * 3.14159265358979323846 / 180.0 * random.direction()});
    out.position += part * scale * random.direction();
    return out;
}

/// Points all over the picture, 2 to 6 units deep.
inline Points cloud(splat::Camera const& camera, int count, Random& random, double noise_px = 0.0)
{
    Points out;
    auto const pose = scene::pose_of(camera);
    for (int i = 0; i < count; ++i) {
        double const z = 4.0 + 2.0 * random.number();
        glm::dvec3 const p{0.6 * z * random.number(), 0.45 * z * random.number(), z};
        double const du = noise_px * random.normal(), dv = noise_px * random.normal();
        out.see(camera, pose.position + glm::transpose(pose.rotation) * p, du, dv);
    }
    return out;
}

} // namespace track_test
