#include "../standard.hpp"
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/scene/ply_output.hpp>
#include <tilemesh/splat/gaussian.hpp>

using namespace tilemesh;

namespace {
scene::Map random_map(std::uint32_t degree)
{
    std::mt19937 random(7 + degree);
    auto const uniform = [&](float low, float high) { return low + (high - low) * static_cast<float>(random() >> 8) * 0x1p-24f; };
    scene::Map map;
    map.sh_degree = degree;
    for (std::uint32_t id = 1; id <= 200; ++id) {
        splat::Gaussian g{};
        float squares = 0;
        for (float& v : g.mean_world) v = uniform(-50, 50);
        for (float& v : g.colour) v = uniform(degree == 0 ? 0.0f : -2.0f, 3);
        for (float& v : g.log_scale) v = uniform(-12, 3);
        for (float& v : g.rotation) v = uniform(-1, 1), squares += v * v;
        for (float& v : g.rotation) v /= std::sqrt(squares);
        g.opacity = id == 1 ? 0.0f : id == 2 ? 1.0f : id == 3 ? 1.2339458e-4f : id == 4 ? 0.99987661f : uniform(0, 1);
        if (id == 5) g.colour[0] = 0, g.log_scale[1] = -87;
        g.id = splat::GaussianId{id};
        map.gaussians.push_back(g);
        for (std::uint32_t k = 0; k < 3 * splat::harmonics_per_channel(degree); ++k) map.harmonics.push_back(uniform(-1, 1));
    }
    return map;
}
} // namespace

TEST_CASE("PLY output: read again, a map of each degree is the same but for rounding, and equal maps have equal bytes")
{
    for (std::uint32_t degree = 0; degree <= 3; ++degree) {
        auto const map = random_map(degree);
        auto const bytes = scene::ply_bytes(map);
        CHECK(bytes == scene::ply_bytes(map));
        CHECK(bytes.size() == bytes.find("end_header\n") + 11 + 200 * 4 * (14 + 3 * splat::harmonics_per_channel(degree)));
        std::istringstream stream(bytes);
        auto const read = scene::read_ply(stream, "map");
        REQUIRE(read.gaussians.size() == 200);
        CHECK(read.notes.empty());
        CHECK(read.sh_degree == degree);
        CHECK(read.harmonics == map.harmonics);
        float off = 0;
        for (std::size_t i = 0; i < 200; ++i) {
            auto const &a = map.gaussians[i], &b = read.gaussians[i];
            CHECK(std::memcmp(a.mean_world, b.mean_world, sizeof a.mean_world) == 0);
            CHECK(std::memcmp(a.log_scale, b.log_scale, sizeof a.log_scale) == 0);
            for (int k = 0; k < 3; ++k) off = std::max(off, std::fabs(a.colour[k] - b.colour[k]) / std::max(1.0f, std::fabs(a.colour[k])));
            for (int k = 0; k < 4; ++k) off = std::max(off, std::fabs(a.rotation[k] - b.rotation[k]));
            off = std::max(off, std::fabs(a.opacity - b.opacity));
        }
        CHECK(off < 3e-7f);
        CHECK(read.gaussians[0].opacity == 0);
        CHECK(read.gaussians[1].opacity == 1);
        CHECK(read.gaussians[4].colour[0] < 1e-7f);
    }
}

TEST_CASE("PLY output: a moved origin is added again, in double; an empty map has no rows")
{
    auto map = random_map(0);
    map.origin = {500000.25, -4000000.5, 10};
    std::istringstream stream(scene::ply_bytes(map));
    auto const read = scene::read_ply(stream, "map", scene::FarMeans::moved);
    REQUIRE(read.gaussians.size() == 200);
    for (std::size_t i = 0; i < 200; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            CHECK(double{read.gaussians[i].mean_world[k]} + read.origin[k] ==
                  doctest::Approx(double{map.gaussians[i].mean_world[k]} + map.origin[k]).epsilon(1e-12));
    std::istringstream none(scene::ply_bytes({}));
    CHECK(scene::read_ply(none, "map").gaussians.empty());
}
