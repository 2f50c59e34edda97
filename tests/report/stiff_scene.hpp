#pragma once
#include "../standard.hpp"
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/rules.hpp>

namespace tests {

/// A scene of 24 Gaussians before a turned camera. The number says its kinds: needles, walls of equal depths, opaque and huge ones.
template <class Record>
struct StiffScene {
    explicit StiffScene(std::uint32_t n) : random(n + 1)
    {
        c.width = 64, c.height = 48, c.fx = 60, c.fy = 65, c.cx = 33.5f, c.cy = 22, c.near_depth = n % 3 == 0 ? 1.0f : 0.25f;
        float q[4], length = 0;
        for (float& v : q) v = random.uniform(-1, 1), length += v * v;
        for (float& v : q) v /= std::sqrt(length);
        float const w = q[0], x = q[1], y = q[2], z = q[3];
        float const r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                               {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                               {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
        bool const straight = n % 4 == 0; // then a wall's depths are exactly equal
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) c.rotation[i][k] = straight ? (i == k ? 1.0f : 0.0f) : r[i][k];
        for (float& v : c.position) v = straight ? 0.0f : random.uniform(-3, 3);
        rules.alpha_min = n % 2 != 0 ? 1 / 255.0f : 1 / 8160.0f;
        rules.transmittance_min = n % 2 != 0 ? 5e-3f : 1e-4f;
        if (n % 3 == 0) rules.alpha_max = 0.99f;
        if (n % 5 == 1) rules.stop = tilemesh::splat::Stop::before_crossing;
        if (n % 5 == 2) rules.coverage = tilemesh::splat::Coverage::preserved;
        if (n % 7 == 3) rules.near_plane = tilemesh::splat::NearPlane::fixed, rules.slope_border = tilemesh::splat::SlopeBorder::of_half_width;
        if (n % 7 == 4) rules.footprint = tilemesh::splat::Footprint::three_sigma_square;
        if (n % 7 == 5) rules.footprint = tilemesh::splat::Footprint::three_sigma_tiles;
        if (n % 7 == 6) rules.jacobian_limit = 0;
        if (n % 11 == 5) rules.dilation = 0.01f;
        rules.background[0] = 0.2f, rules.background[1] = n % 5 == 0 ? 0.9f : 0.0f;
        for (std::uint32_t i = 0; i < 24; ++i) {
            Record g{};
            float const depth = straight ? 2.0f : random.uniform(0.2f, 4);
            float const v[3] = {random.uniform(-.5f, .5f) * depth, random.uniform(-.35f, .35f) * depth, depth};
            for (int k = 0; k < 3; ++k) {
                g.mean_world[k] = c.position[k] + c.rotation[0][k] * v[0] + c.rotation[1][k] * v[1] + c.rotation[2][k] * v[2];
                g.colour[k] = random.uniform(0, 1.5f);
            }
            for (float& k : g.rotation) k = random.uniform(-1, 1);
            for (float& k : g.log_scale) k = n % 5 == 1 ? random.uniform(-9, 1.5f) : n % 5 == 2 ? random.uniform(-2, 1) : random.uniform(-6, -1);
            g.opacity = i % 10 == 9 ? 1.0f : n % 7 == 0 ? random.uniform(.95f, 1) : random.uniform(.02f, 1);
            if constexpr (Record::sh_degree > 0)
                for (float& h : g.harmonics) h = random.uniform(-.4f, .4f);
            g.id = tilemesh::splat::GaussianId{i * 7919u % 101u + 1u};
            records.push_back(g);
        }
    }
    Random random;
    tilemesh::splat::Camera c{};
    tilemesh::splat::Rules rules;
    std::vector<Record> records;
};

} // namespace tests
