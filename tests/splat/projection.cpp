// test: without asan tsan
#include "pose_reference.hpp"

using namespace tilemesh;
using namespace tilemesh::splat;

namespace {
Tiling whole(Camera const& c) { return make_tiling(c.width, c.height, 32, 20); }
} // namespace

TEST_CASE("projection: mean, factors and alpha agree with the textbook chain in double")
{
    auto const camera = support::lens(1280, 720, 0.1f);
    Rules const rules;
    auto const view = make_view(camera, rules);
    auto const in_double = support::pose::camera_of(camera, rules);
    double worst_mean = 0, worst_alpha = 0;
    std::uint32_t seen = 0;
    for (auto const& g : support::cloud(20000, 1)) {
        auto const s = project(g, view, whole(camera));
        if (!s.visible()) continue;
        ++seen;
        support::pose::Splat t;
        REQUIRE(support::pose::project(g, in_double, rules, t));
        worst_mean = std::max({worst_mean, std::abs(double(s.mean_px[0]) - t.u), std::abs(double(s.mean_px[1]) - t.v)});
        for (double dx : {-2.0, 0.0, 1.5})
            for (double dy : {-1.0, 0.5, 3.0}) {
                float const px = s.mean_px[0] + float(dx), py = s.mean_px[1] + float(dy);
                worst_alpha = std::max(worst_alpha, std::abs(double(alpha_at(s, px, py)) - t.raw_alpha(t.u + dx, t.v + dy)));
            }
    }
    MESSAGE(seen, " visible; mean off by at most ", worst_mean, " px, alpha by ", worst_alpha);
    CHECK(seen > 10000);
    CHECK(worst_mean < 2e-4);
    CHECK(worst_alpha < 1e-3); // some are needles: this is the conditioning of their inputs
}

TEST_CASE("projection: the opacity box holds every pixel that sees at least alpha_min, also if the logarithm is about 0 or alpha_min is tiny")
{
    auto const camera = support::lens(160, 120);
    constexpr float smallest = std::numeric_limits<float>::min();
    std::uint32_t outside = 0, inside = 0;
    // Below 1e-40, the rounding of alpha itself is more than 1e-5 of it.
    for (float const alpha_min : {1.0f / 255, 0.25f, 1.0f, 1e-30f, smallest, 1e-40f}) {
        Rules rules;
        rules.alpha_min = alpha_min;
        auto const view = make_view(camera, rules);
        float opacity = alpha_min;
        for (std::uint32_t step = 0; step < (alpha_min == 1.0f / 255 ? 25u : 24u); ++step) {
            for (auto g : support::cloud(step < 24 ? 12 : 3000, 40 + step)) { // the last cloud has opacities of its own
                if (step < 24) g.opacity = opacity;
                auto const s = project(g, view, whole(camera));
                auto const r = s.rect();
                for (std::uint32_t y = 0; s.visible() && y < camera.height; ++y)
                    for (std::uint32_t x = 0; x < camera.width; ++x) {
                        float const alpha = alpha_at(s, float(x) + 0.5f - camera.cx, float(y) + 0.5f - camera.cy);
                        if (!(alpha >= alpha_min)) continue;
                        ++(x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1 ? inside : outside);
                    }
            }
            opacity = std::min(1.0f, step < 12 ? std::nextafter(opacity, 2.0f) : opacity * 1.5f);
        }
    }
    CHECK(outside == 0);
    CHECK(inside > 100000);
}

TEST_CASE("projection: the anchor is one tile, half-open, and lies in the rectangle")
{
    auto const camera = support::flat_camera(64, 40);
    auto const tiling = make_tiling(64, 40, 16, 10);
    auto const view = make_view(camera, Rules{});
    auto const anchor = [&](float x, float y) { return project(support::ball(1, x, y, 3), view, tiling).anchor; };
    CHECK(anchor(15.99f, 5) == TileId::at(0, 0));
    CHECK(anchor(16, 5) == TileId::at(1, 0));
    CHECK(anchor(16, 10) == TileId::at(1, 1));
    CHECK(anchor(std::nextafter(16.0f, 0.0f), std::nextafter(10.0f, 0.0f)) == TileId::at(0, 0));
    CHECK(anchor(0, 0) == TileId::at(0, 0));
    CHECK(anchor(-5, 20) == TileId::at(0, 2));   // off screen: the edge, not the row before
    CHECK(anchor(68, 20) == TileId::at(3, 2));   // nor the next
    CHECK(anchor(30, -4) == TileId::at(1, 0));
    CHECK(anchor(30, 44) == TileId::at(1, 3));
    support::Random random(9);
    for (int i = 0; i < 5000; ++i) {
        float const x = random.uniform(-20, 84), y = random.uniform(-20, 60), sigma = random.uniform(0.1f, 20);
        auto const s = project(support::ball(1, x, y, sigma), view, tiling);
        if (!s.visible()) continue;
        CHECK(covers(s, tiling, s.anchor));
        CHECK(s.anchor.x() < tiling.columns);
        CHECK(s.anchor.y() < tiling.rows);
    }
}

TEST_CASE("projection: the near plane and alpha_min are met exactly")
{
    auto camera = support::lens(64, 40);
    auto const visible = [&](Gaussian const& g) { return project(g, make_view(camera, Rules{}), whole(camera)).visible(); };
    Gaussian g = support::cloud(1, 3)[0];
    g.mean_world[0] = g.mean_world[1] = 0;
    g.opacity = 0.5f;
    g.mean_world[2] = 0.2f;
    CHECK_FALSE(visible(g));
    g.mean_world[2] = std::nextafter(0.2f, 1.0f);
    CHECK(visible(g));
    g.mean_world[2] = -1;
    CHECK_FALSE(visible(g));
    g.mean_world[2] = 1;
    g.opacity = 1.0f / 255;
    CHECK(visible(g));
    g.opacity = std::nextafter(1.0f / 255, 0.0f);
    CHECK_FALSE(visible(g));
}

TEST_CASE("projection: a Gaussian that cannot be drawn is invisible, never a NaN")
{
    auto const camera = support::lens(64, 40);
    auto const view = make_view(camera, Rules{});
    float const bad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                         -std::numeric_limits<float>::infinity(), 3e38f, -3e38f, 1e-45f, 0.0f};
    Gaussian const good = support::ball(1, 0, 0, 1);
    std::uint32_t seen = 0;
    for (std::uint32_t word = 0; word < 14; ++word)
        for (float v : bad) {
            Gaussian g = good;
            g.mean_world[2] = 2;
            std::memcpy(reinterpret_cast<char*>(&g) + 4 * word, &v, 4);
            auto const s = project(g, view, whole(camera));
            if (!s.visible()) continue;
            ++seen;
            auto const r = s.rect();
            CHECK_FALSE(r.empty());
            CHECK(r.x1 <= 64u);
            CHECK(r.y1 <= 40u);
            for (float x : {-32.0f, 0.0f, 31.0f})
                CHECK_MESSAGE(std::isfinite(alpha_at(s, x, 0.0f)), "word ", word, " value ", v);
        }
    CHECK(seen > 0);
}

TEST_CASE("projection: large coordinates cancel before they are rotated")
{
    auto camera = support::lens(1280, 720, 0.3f);
    auto const near_map = support::cloud(200, 4);
    for (auto g : near_map) {
        auto far_camera = camera;
        auto far = g;
        for (int i = 0; i < 3; ++i) {
            float const offset = 1048576.0f; // 2^20: the grid of floats there is 1/8
            far_camera.position[i] = offset;
            far.mean_world[i] = std::round(g.mean_world[i] * 8) / 8 + offset;
            g.mean_world[i] = std::round(g.mean_world[i] * 8) / 8;
        }
        auto const a = project(g, make_view(camera, Rules{}), whole(camera));
        auto const b = project(far, make_view(far_camera, Rules{}), whole(camera));
        CHECK(std::memcmp(&a, &b, sizeof a) == 0);
    }
}

TEST_CASE("projection: known answers of the two footprints")
{
    auto camera = support::flat_camera(640, 400);
    camera.cx = 320;
    camera.cy = 200;
    Rules rules;
    auto const rect = [&](float sigma, float opacity) {
        return project(support::ball(1, 0.5f, 0.5f, sigma, opacity), make_view(camera, rules), whole(camera)).rect();
    };
    // Opaque: t = sqrt(2 ln 255) = 3.329; sigma^2 + 0.3.
    auto r = rect(10, 1);
    CHECK(r.x0 == 320 - 33);
    CHECK(r.x1 == 320 + 34);
    CHECK(r.y0 == 200 - 33);
    r = rect(10, 1.5f / 255); // faint: t = sqrt(2 ln 1.5) = 0.9005
    CHECK(r.x0 == 320 - 9); // 9.02 pixels left of 320.5
    rules.footprint = Footprint::three_sigma_square;
    r = rect(10, 1); // ceil(3 sqrt(100.3)) = 31
    CHECK(r.x0 == 320 - 31);
    CHECK(r.x1 == 320 + 32);
    r = rect(1e9f, 1); // must not wrap
    CHECK(r.x0 == 0);
    CHECK(r.x1 == 640);
}
