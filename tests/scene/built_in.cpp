#include "support.hpp"
#include <glm/mat3x3.hpp>
#include <glm/vec4.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/detail/brush.hpp>
#include <tilemesh/scene/pose.hpp>

using namespace scene_test;
using namespace tilemesh;

namespace {

double sigma(splat::Gaussian const& g, int which)
{
    float s[3] = {g.log_scale[0], g.log_scale[1], g.log_scale[2]};
    std::sort(s, s + 3);
    return std::exp(static_cast<double>(s[which]));
}

} // namespace

TEST_CASE("PCG32 draws the numbers of its reference implementation")
{
    // The first line that pcg32-demo of pcg-c-basic 0.9 prints: seed 42, stream 54.
    scene::detail::Pcg32 random(42, 54);
    for (std::uint32_t const expected : {0xa15c02b7u, 0x7b47f409u, 0xba1d3330u, 0x83d2f293u, 0xbfa4784bu, 0xcbed606eu})
        CHECK(random.next() == expected);
    for (int i = 0; i < 1000; ++i) {
        double const draw = random.uniform();
        REQUIRE((draw >= 0.0 && draw < 1.0));
    }
}

TEST_CASE("the built-in map has the size and the ids that are promised, sound records, and is the same on every call")
{
    auto const map = scene::built_in_map(), again = scene::built_in_map();
    CHECK(map.name == "built_in");
    CHECK(map.path.empty());
    CHECK(map.rejected == 0);
    CHECK(map.gaussians.size() >= 38000);
    CHECK(map.gaussians.size() <= 42000);
    REQUIRE(map.gaussians.size() == again.gaussians.size());
    CHECK(std::memcmp(map.gaussians.data(), again.gaussians.data(), map.gaussians.size() * 60) == 0);
    std::size_t wrong_ids = 0, wrong = 0;
    for (std::size_t i = 0; i < map.gaussians.size(); ++i) {
        auto const& g = map.gaussians[i];
        wrong_ids += static_cast<std::uint32_t>(g.id) != i + 1;
        double norm = 0.0;
        bool sound = g.opacity > 0.0f && g.opacity <= 1.0f;
        for (float q : g.rotation) norm += static_cast<double>(q) * static_cast<double>(q);
        for (int k = 0; k < 3; ++k)
            sound = sound && std::isfinite(g.mean_world[k]) && g.colour[k] >= 0.0f && g.colour[k] < 4.0f && g.log_scale[k] > -12.0f &&
                    g.log_scale[k] < 2.0f;
        wrong += !sound || !(std::fabs(norm - 1.0) < 1e-6);
    }
    CHECK(wrong_ids == 0);
    CHECK(wrong == 0);
}

TEST_CASE("the built-in map holds what SLAM maps hold: opaque ones, needles, discs, blobs")
{
    auto const map = scene::built_in_map();
    std::size_t opaque = 0, needles = 0, discs = 0, blobs = 0;
    std::set<float> opacities;
    for (auto const& g : map.gaussians) {
        opaque += g.opacity == 1.0f;
        needles += sigma(g, 2) / sigma(g, 0) >= 100.0 && sigma(g, 1) / sigma(g, 0) < 2.0;
        discs += sigma(g, 1) / sigma(g, 0) > 5.0;
        blobs += sigma(g, 2) > 1.0;
        opacities.insert(g.opacity);
    }
    double const share = static_cast<double>(opaque) / static_cast<double>(map.gaussians.size());
    CHECK(share >= 0.02);
    CHECK(share <= 0.04);
    CHECK(needles >= 300);
    CHECK(discs > map.gaussians.size() / 2);
    CHECK(blobs >= 8);
    CHECK(blobs <= 15);
    CHECK(opacities.size() > 10000);
}

TEST_CASE("the camera of the built-in map shows the desk, its lettering and no empty border")
{
    auto const map = scene::built_in_map();
    auto const camera = scene::built_in_camera({1280, 720});
    CHECK(camera.width == 1280);
    CHECK(camera.height == 720);
    CHECK(camera.position[2] < -1.0f);

    std::vector<int> hits(16 * 9, 0);
    std::size_t shown = 0, lettering = 0;
    for (auto const& g : map.gaussians) {
        glm::dvec3 const p{g.mean_world[0], g.mean_world[1], g.mean_world[2]};
        if (to_view(camera, p).z <= static_cast<double>(camera.near_depth)) continue;
        auto const pixel = to_pixel(camera, p);
        if (!(pixel.x >= 0 && pixel.y >= 0 && pixel.x < 1280 && pixel.y < 720)) continue;
        ++shown;
        // The letters are the brightest fine dots of the upper half, in its middle.
        lettering += pixel.y < 240 && std::fabs(pixel.x - 640) < 320 && g.colour[0] + g.colour[1] + g.colour[2] > 2.0f && sigma(g, 2) < 0.004;
        ++hits[static_cast<std::size_t>(pixel.y / 80) * 16 + static_cast<std::size_t>(pixel.x / 80)];
    }
    CHECK(static_cast<double>(shown) > 0.75 * static_cast<double>(map.gaussians.size()));
    CHECK(lettering > 1000);
    // The lower half of the picture is desk: no cell of it is without a Gaussian.
    for (std::size_t cell = 16 * 5; cell < hits.size(); ++cell) CHECK(hits[cell] > 0);
    CHECK(has(error_of([] { scene::built_in_camera({0, 720}); }), "0 x 720"));
}

TEST_CASE("a frame becomes a quaternion whichever axis is longest")
{
    scene::Map map;
    scene::detail::Brush brush(map, 1);
    std::vector<glm::dmat3> frames{glm::dmat3{1.0}};
    for (auto const& q : {glm::dvec4{0.1, 1, 0.2, 0.3}, glm::dvec4{-0.1, 0.2, 1, 0.3}, glm::dvec4{0.05, 0.2, 0.3, -1}, glm::dvec4{0, 1, 0, 0},
                          glm::dvec4{0, 0, 1, 0}, glm::dvec4{0, 0, 0, 1}})
        frames.push_back(scene::rotation_matrix(q[0], q[1], q[2], q[3]));
    for (auto const& frame : frames) {
        brush.dab({}, frame, {1, 2, 3}, {}, 1.0);
        float const* q = map.gaussians.back().rotation;
        auto const back = scene::rotation_matrix(q[0], q[1], q[2], q[3]);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) CHECK(std::fabs(back[i][j] - frame[i][j]) < 1e-6);
    }
}
