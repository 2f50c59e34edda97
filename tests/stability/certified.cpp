// test: optimised, cost 8
// Each row of the catalogue as a picture: its enclosure has no undecided pixel, and the mesh's picture with the cut-offs of `evaluation` is certified.
// A row that is no picture, or whose records no interval encloses, says why.
#include "catalogue.hpp"
#include "machines.hpp"
#include <tilemesh/report/enclosure.hpp>
#include <tilemesh/scene/built_in.hpp>

namespace {

using namespace tilemesh;
using tests::Random;

constexpr float inf = std::numeric_limits<float>::infinity(), nan_value = std::numeric_limits<float>::quiet_NaN();

struct Picture {
    scene::Map map;
    splat::Camera camera{};
    splat::Rules rules;
    std::uint64_t not_enclosed = 0;
    double levels = 0.1; ///< the picture is no farther off
    Random random{1};

    Picture()
    {
        for (int i = 0; i < 3; ++i) camera.rotation[i][i] = 1;
        camera.fx = camera.fy = 100, camera.cx = 64, camera.cy = 48, camera.width = 128, camera.height = 96, camera.near_depth = 0.2f;
    }
    splat::Gaussian& add(float x, float y, float z, float a, float b, float c, float opacity = 0.7f)
    {
        splat::Gaussian g{};
        g.mean_world[0] = x, g.mean_world[1] = y, g.mean_world[2] = z;
        g.log_scale[0] = a, g.log_scale[1] = b, g.log_scale[2] = c;
        for (float& q : g.rotation) q = random.uniform(-1, 1);
        for (float& v : g.colour) v = random.uniform(0, 1);
        g.opacity = opacity;
        g.id = splat::GaussianId{static_cast<std::uint32_t>(map.gaussians.size() + 1)};
        map.gaussians.push_back(g);
        return map.gaussians.back();
    }
    /// n splats on the screen, their logarithms of scales from the two ranges.
    void cloud(int n, float near, float far, float long_least, float long_most, float least, float most, float opacity = 0.7f)
    {
        for (int i = 0; i < n; ++i) {
            float const z = random.uniform(near, far), x = random.uniform(-.6f, .6f) * z, y = random.uniform(-.45f, .45f) * z;
            float const a = random.uniform(long_least, long_most), b = random.uniform(least, most), c = random.uniform(least, most);
            add(x, y, z, a, b, c, opacity);
        }
    }
    void layers(int n, float opacity, float from, float step)
    {
        for (int i = 0; i < n; ++i) add(0, 0, from + step * static_cast<float>(i), 3, 3, 3, opacity);
    }
    /// Pixels per unit of sigma at depth 1: a ball of so many pixels at depth z.
    static float ball(float px, float z) { return std::log(px * z / 100); }
};

struct Row {
    std::vector<int> rows;
    char const* why_not; ///< null: it is a picture
    void (*fill)(Picture&);
};

Row const rows[] = {
    {{1}, nullptr, [](Picture& p) { p.cloud(60, .5f, 5, -2, 1, -9.2f, -9.2f); }},
    {{2, 3, 4, 54}, nullptr, [](Picture& p) { p.cloud(60, 2, 9, 1, 4, -6.9f, -6.9f); }},
    {{5, 12}, nullptr, [](Picture& p) { for (float z : {1.0f, 2.0f}) p.add(.1f, 0, z, p.ball(1000, z), p.ball(.55f, z), p.ball(.55f, z)), p.add(0, .1f, z, p.ball(5000, z), p.ball(.55f, z), p.ball(.55f, z)); }},
    {{6}, nullptr, [](Picture& p) { for (int i = 0; i < 40; ++i) p.add(p.random.uniform(-1, 1), p.random.uniform(-.8f, .8f), 2, -3, -1, -13.8f); }},
    {{7}, nullptr, [](Picture& p) { p.cloud(60, .21f, 1, -4.5f, -1.5f, -4.5f, -1.5f); }},
    {{8, 53, 61}, nullptr, [](Picture& p) { p.cloud(400, 2, 10, -3.9f, .47f, -3.9f, .47f); }},
    {{9, 23, 36, 50}, "the model has no such thing, as the row's test says", nullptr},
    {{10}, nullptr, [](Picture& p) { p.add(.01f, .01f, 2, -40, -40, -40, .9f); }},
    {{11, 13, 35, 48, 87}, nullptr, [](Picture& p) { for (float px : {1.0f, 10.0f, 20.0f, 60.0f, 100.0f, 300.0f, 5000.0f}) p.add(.02f * px / 100, 0, 1 + px / 1000, p.ball(px, 1), p.ball(px, 1), p.ball(px, 1), px == 20 ? 1 : .3f); }},
    {{14, 37}, nullptr, [](Picture& p) { p.add(0, 0, 1, 17.6f, 17.6f, 17.6f), p.add(0, 0, 2, 17.2f, 17.2f, 17.2f, 1); }},
    {{15}, nullptr, [](Picture& p) { auto& g = p.add(0, 0, 2, -1, -1.5f, -2); g.rotation[0] = 1, g.rotation[1] = g.rotation[2] = g.rotation[3] = 0; }},
    {{16}, nullptr, [](Picture& p) { p.cloud(9, 2, 3, -2, -1, -2, -1); for (float& q : p.map.gaussians[4].rotation) q = 0; }},
    {{17, 18, 19}, nullptr, [](Picture& p) { p.cloud(40, 2, 3, -2, -1, -4, -2); float const size[] = {1e-23f, 1e20f, 1.001f, 1.01f, 2}; for (std::size_t i = 0; i < 40; ++i) for (float& q : p.map.gaussians[i].rotation) q *= size[i % 5]; }},
    {{20}, nullptr, [](Picture& p) { for (float s : {22.2f, 44.4f, 88.8f}) p.add(0, 0, 2, s, s, s, .3f); p.add(0, 0, 3, 30, 0, 0); }},
    {{21}, nullptr, [](Picture& p) { for (float s : {-26.0f, -43.7f, -52.0f}) p.add(.013f * s, 0, 2, s, s, s, .9f); }},
    {{22}, nullptr, [](Picture& p) { p.add(0, 0, 2, -2, -2, -2), p.add(0, 0, 3, -inf, -2, -2, 1); p.not_enclosed = 1; }}, // a size of 0 has no logarithm that a ball holds
    {{24, 25, 26, 27, 28}, nullptr, [](Picture& p) { for (float z : {1e-10f, 1e-8f, 0.2f, std::nextafter(0.2f, 1.0f), -1.0f, -.01f, 0.0f}) p.add(0, 0, z, -4.6f, -4.6f, z < 0 ? 1.0f : -4.6f); }},
    {{29}, nullptr, [](Picture& p) { p.camera.near_depth = 1e-5f; p.add(1e-5f, 0, 1e-4f, -12, -12, -12); }},
    {{30, 31}, nullptr, [](Picture& p) { for (float& v : p.camera.position) v = 5.5e6f; p.cloud(40, 4, 9, -1, 0, -2, 0); for (auto& g : p.map.gaussians) for (float& v : g.mean_world) v += 5.5e6f; p.levels = 1; }},
    {{32}, nullptr, [](Picture& p) { p.cloud(200, 1, 10, -3, -1, -3, -1); p.add(0, 0, 5.3e8f, 15, 15, 15), p.add(0, 0, 7e8f, 15, 15, 15); }},
    {{33, 34}, nullptr, [](Picture& p) { p.add(3, 0, 2, 0, -1, -1), p.add(100, 0, 2, 3, 3, 3), p.add(10, 3, 1, -3, -3, 2.5f); }},
    {{38}, "it is a count of pairs, no picture", nullptr},
    {{39, 40, 41}, nullptr, [](Picture& p) { p.cloud(40, 2, 3, -2, -1, -4, -2); auto& g = p.map.gaussians; g[0].opacity = nan_value, g[1].log_scale[1] = inf, g[2].mean_world[0] = nan_value, g[3].colour[2] = inf, g[4].rotation[3] = nan_value, g[5].log_scale[0] = nan_value; }},
    {{42, 47, 49}, nullptr, [](Picture& p) { p.layers(1000, 0.0039f, 1, 1e-3f), p.layers(20, 0.001086f, 3, .1f), p.layers(100, 1e-5f, 6, .1f); p.rules.alpha_min = 1e-7f; }},
    {{43}, "it is how a file's opacity is read, which is outside the proof", nullptr},
    {{44, 45, 46}, nullptr, [](Picture& p) { p.layers(1, 1, 1, 0), p.layers(2, .99f, 2, 1), p.layers(1, .995f, 5, 1); p.rules.alpha_max = .99f; }},
    {{51, 52, 69}, nullptr, [](Picture& p) { p.layers(1000, .004f, 1, 1e-3f); }},
    {{55}, nullptr, [](Picture& p) { p.layers(2000, .5f, 2, 0); }},
    {{56, 57, 58, 88}, nullptr, [](Picture& p) { for (int i = 0; i < 64; ++i) p.add(p.random.uniform(-.5f, .5f), 0, 2 + .125f * static_cast<float>(i % 8), -1, -1, -1, .5f).id = splat::GaussianId{16777216u + static_cast<std::uint32_t>(i * 37 % 64)}; }},
    {{59, 60}, nullptr, [](Picture& p) { p.cloud(60, 1, 4, -3, -1, -3, -1); for (std::size_t i = 0; i < 60; i += 4) p.map.gaussians[i].mean_world[2] = i % 8 == 0 ? nan_value : -1; }},
    {{62, 63}, "it is what a sort costs and touches, no picture", nullptr},
    {{64}, nullptr, [](Picture& p) { for (float px : {255.0f, 1000.0f, 20000.0f}) p.add(0, 0, 1 + px * 1e-4f, p.ball(px, 1), p.ball(px, 1), p.ball(px, 1), .4f); }},
    {{65, 67, 68}, nullptr, [](Picture& p) { p.cloud(100, 2, 3, -9.2f, 0, -9.2f, -1); }},
    {{66}, nullptr, [](Picture& p) { p.camera.width = 1280, p.camera.cx = 60; for (int i = 0; i < 30; ++i) p.add(9.7f + .08f * static_cast<float>(i), 0, 1, -3, -3, -3); }},
    {{70}, "it is how poses drift; a picture has the camera that it is given", nullptr},
    {{71, 72, 73, 74, 75, 76, 77, 78, 79, 80, 81, 82, 83, 84, 85, 86, 89}, "it is where records live and which messages they cost; its pictures are those of the formula, bit for bit", nullptr},
    {{90}, nullptr, [](Picture& p) { p.camera.width = 127, p.camera.height = 73; p.add(0, 0, 2, -1, -1, -1); }},
};

TEST_CASE("the catalogue is certified, or says why not")
{
    std::set<int> seen;
    double farthest = 0;
    for (auto const& row : rows) {
        for (int const n : row.rows) CHECK(seen.insert(n).second);
        if (row.why_not != nullptr) continue;
        CAPTURE(row.rows.front());
        Picture p;
        p.rules = splat::with_quality(splat::lossless.rules, splat::Quality::evaluation);
        row.fill(p);
        auto const e = report::enclose(p.map.gaussians, p.camera, p.rules);
        CHECK(e.not_enclosed.size() == p.not_enclosed);
        CHECK(e.count(report::Enclosure::Decided::undecided) == 0);
        CHECK(255 * e.widest() < 1e-8);
        auto const frame = stability::render(stability::Kind::roomy, p.map, p.camera, {.grid = {4, 3}}, &p.rules);
        auto const c = report::certify(e, frame.image);
        INFO(report::text_of(c));
        if (p.not_enclosed == 0) CHECK(c.largest <= p.levels);
        if (p.not_enclosed == 0) farthest = std::max(farthest, c.largest);
    }
    CHECK(seen.size() == 90);
    MESSAGE("farthest " << farthest << " levels");
}

TEST_CASE("the built-in map: what the first page says is proved")
{
    auto const map = scene::built_in_map();
    auto const camera = scene::built_in_camera({320, 180});
    for (bool const fine : {false, true}) {
        auto const rules = fine ? splat::with_quality(splat::lossless.rules, splat::Quality::evaluation) : splat::lossless.rules;
        auto const e = report::enclose(map.gaussians, camera, rules, {.threads = 2});
        CHECK(e.not_enclosed.empty());
        CHECK(e.count(report::Enclosure::Decided::undecided) == 0);
        auto const c = report::certify(e, stability::render(stability::Kind::mk2, map, camera, {}, &rules).image);
        MESSAGE(report::text_of(c));
        CHECK(c.largest < (fine ? 0.04 : 1.0));
        CHECK(c.p99 < 0.01);
    }
}

} // namespace
