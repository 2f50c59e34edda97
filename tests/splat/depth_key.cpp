// The depth order: its key rises with the depth, and orders neighbours that a float32 orders wrongly.
#include "support.hpp"
#include <tilemesh/splat/depth_key.hpp>
#include <tilemesh/splat/project_all.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;

namespace {
std::uint32_t key(double depth)
{
    auto const rounded = static_cast<float>(depth);
    return key_of_depth(rounded, static_cast<float>(depth - double{rounded}));
}
float next(float v, int steps)
{
    return __builtin_bit_cast(float, __builtin_bit_cast(std::uint32_t, v) + static_cast<std::uint32_t>(steps));
}

double exact_depth(Camera const& c, Gaussian const& g)
{
    long double z = 0;
    for (int k = 0; k < 3; ++k) z += static_cast<long double>(c.rotation[2][k]) * (static_cast<long double>(g.mean_world[k]) - c.position[k]);
    return static_cast<double>(z);
}
/// The depth in float32, from which a picture's other words are made.
float rounded_depth(Camera const& c, Gaussian const& g)
{
    float const x = g.mean_world[0] - c.position[0], y = g.mean_world[1] - c.position[1], z = g.mean_world[2] - c.position[2];
    float const zz = c.rotation[2][2] * z, yz = c.rotation[2][1] * y + zz;
    return c.rotation[2][0] * x + yz;
}

/// Pairs of balls in the middle of a turned camera's picture: the first has the lower id and is behind the second, but not by its float32.
std::vector<std::array<Gaussian, 2>> inverted_pairs(Camera const& camera, std::size_t wanted)
{
    tests::Random random(7);
    std::vector<std::array<Gaussian, 2>> pairs;
    for (int tries = 0; pairs.size() < wanted && tries < 1000000; ++tries) {
        std::array<Gaussian, 2> pair;
        float const z = random.uniform(1.0f, 8.0f);
        for (std::uint32_t i = 0; i < 2; ++i) {
            auto& g = pair[i] = support::ball(i + 1, 0, 0, 0.5f * z, 0.99f);
            float const x = random.uniform(-0.01f, 0.01f), y = random.uniform(-0.01f, 0.01f);
            for (int k = 0; k < 3; ++k)
                g.mean_world[k] = camera.position[k] + camera.rotation[2][k] * z + camera.rotation[0][k] * x + camera.rotation[1][k] * y;
            for (int k = 0; k < 3; ++k) g.colour[k] = k == static_cast<int>(i) ? 1.0f : 0.0f;
        }
        double const behind = exact_depth(camera, pair[0]) - exact_depth(camera, pair[1]);
        if (behind > 0x1p-26 * static_cast<double>(z) && rounded_depth(camera, pair[0]) <= rounded_depth(camera, pair[1])) pairs.push_back(pair);
    }
    return pairs;
}
} // namespace

TEST_CASE("depth key: it rises over all depths, through the borders of its zones, and is never 0 or all ones")
{
    std::uint32_t before = 0;
    for (std::uint32_t bits = 1; bits <= 0x7f7fffffu; bits += 4099) {
        auto const depth = __builtin_bit_cast(float, bits);
        auto const k = key(double{depth});
        if (k <= before) FAIL_CHECK("at ", depth);
        if (depth_of_key(k) != depth) FAIL_CHECK("back from ", depth);
        before = k;
    }
    CHECK(before < 0xffffffffu);
    for (float const border : {0x1p-6f, 0x1p10f}) {
        CHECK(key(double{next(border, -1)}) < key(double{border}));
        CHECK(key(double{border}) < key(double{next(border, 1)}));
        std::uint32_t last = 0;
        for (double z = double{border} * (1 - 1e-6); z < double{border} * (1 + 1e-6); z *= 1 + 3e-10) {
            if (key(z) < last) FAIL_CHECK("at ", z);
            last = key(z);
        }
    }
    CHECK(key(1 + 0x1p-27) == key(1) + 1); // 28 significant bits
    CHECK(key(1 + 0x1p-29) == key(1));
    CHECK(key(1 - 0x1p-27) == key(1) - 1); // a half of a step where the float32 is the power of two
    CHECK(key(2048 + 0x1p-12) == key(2048) + 1); // 24
    CHECK(depth_of_key(0) == 0);
}

TEST_CASE("depth key: records in lanes have the keys of records one by one, also stiff ones and depths outside the fine zone")
{
    auto camera = support::lens(64, 48, 0.2f);
    camera.near_depth = 1e-6f;
    auto const view = make_view(camera, {});
    auto const tiling = make_tiling(64, 48, 8, 6);
    for (float const scale : {1e-4f, 1.0f, 1e4f}) {
        auto records = support::cloud(400, 5);
        for (auto& g : records)
            for (int k = 0; k < 3; ++k) g.mean_world[k] *= scale, g.log_scale[k] += std::log(scale);
        std::vector<Splat> splats(records.size());
        project_all(records.data(), static_cast<std::uint32_t>(records.size()), view, tiling, splats.data());
        std::uint32_t visible = 0;
        for (std::size_t i = 0; i < records.size(); ++i) {
            auto const one = project(records[i], view, tiling);
            CHECK(splats[i].depth_key == one.depth_key);
            if (!one.visible()) continue;
            ++visible;
            CHECK(one.depth_key == depth_key(records[i], view));
            auto const exact = key(exact_depth(camera, records[i])); // the sum of two floats may differ in the last bit
            CHECK((one.depth_key == exact || one.depth_key + 1 == exact || one.depth_key == exact + 1));
        }
        CHECK(visible > 20);
    }
}

TEST_CASE("depth key: of neighbours that a float32 orders wrongly the nearer one is in front, in both programs and in the naive picture")
{
    auto camera = support::lens(48, 40, 0.7f);
    for (int k = 0; k < 3; ++k) camera.position[k] = 0.3f + 0.1f * static_cast<float>(k);
    auto const pairs = inverted_pairs(camera, 6);
    REQUIRE(pairs.size() == 6);
    for (auto const& pair : pairs) {
        scene::Map map;
        map.gaussians.assign(pair.begin(), pair.end());
        auto const view = make_view(camera, {});
        CHECK(depth_key(pair[1], view) < depth_key(pair[0], view));
        auto const naive = report::render_naive(std::span<Gaussian const>(map.gaussians), camera, with_quality({}, Quality::evaluation));
        auto const middle = [](report::Image const& image) { return image.pixel(24, 20); };
        CHECK(middle(naive)[1] > 10 * middle(naive)[0]);
        for (auto const program : {report::Program::anchored, report::Program::homes}) {
            RendererOptions const options{.arithmetic = Arithmetic::precise, .quality = Quality::evaluation, .program = program};
            CHECK(Renderer{map, options}.render(camera).image.rgb == naive.rgb);
        }
    }
    Gaussian twin = pairs[0][0]; // equal depths: the lower id is in front
    twin.id = GaussianId{9};
    std::swap(twin.colour[0], twin.colour[1]);
    auto const naive = report::render_naive(std::span<Gaussian const>(std::vector{twin, pairs[0][0]}), camera, {});
    CHECK(naive.pixel(24, 20)[0] > 10 * naive.pixel(24, 20)[1]);
}
