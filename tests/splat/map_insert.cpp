// test: cost 1
#include "support.hpp"
#include <tilemesh/splat/footprint.hpp>
#include <tilemesh/splat/map/insert.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
using splat::map::CellGrid, splat::map::CellSums, splat::map::InsertRules, splat::map::RemoveRules, splat::map::ShownPixel;

namespace {
constexpr float none = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();

/// A cell of four equal pixels.
CellSums four(TargetPixel const& target, ShownPixel const& shown)
{
    CellSums sums;
    for (int i = 0; i < 4; ++i) sums.add(target, shown);
    return sums;
}
ShownPixel shown_as(TargetPixel const& t, float cover = 1)
{
    return {{t.rgb[0], t.rgb[1], t.rgb[2]}, cover > 0.5f ? t.depth : 0.0f, cover};
}
constexpr InsertRules rules{};
} // namespace

TEST_CASE("insertion: a cell that the map explains gets nothing, an open, deep or differently coloured one does")
{
    TargetPixel const target{{0.5f, 0.25f, 0.75f}, 2};
    CHECK_FALSE(four(target, shown_as(target)).wants_gaussian(rules));
    CHECK(four(target, {{0, 0, 0}, 0, 0}).wants_gaussian(rules)); // an empty map

    // Coverage: below a half on the mean of the pixels, not of one pixel.
    CHECK_FALSE(four(target, shown_as(target, 0.5f)).wants_gaussian(rules));
    CHECK(four(target, shown_as(target, 0.4999f)).wants_gaussian(rules));
    CellSums half;
    for (float const cover : {0.0f, 0.0f, 1.0f, 1.0f}) half.add(target, shown_as(target, cover));
    CHECK_FALSE(half.wants_gaussian(rules));
    CellSums less;
    for (float const cover : {0.0f, 0.0f, 0.75f, 1.0f}) less.add(target, shown_as(target, cover));
    CHECK(less.wants_gaussian(rules));

    // Depth: the map is behind by 5 % and more; what is in front of the target does not count.
    auto at = shown_as(target);
    at.depth = 2.0999f;
    CHECK_FALSE(four(target, at).wants_gaussian(rules));
    at.depth = 2.1001f;
    CHECK(four(target, at).wants_gaussian(rules));
    at.depth = 0.5f;
    CHECK_FALSE(four(target, at).wants_gaussian(rules));

    // Colour: the mean over channels, of either sign.
    at = shown_as(target);
    at.rgb[0] += 0.44f;
    CHECK_FALSE(four(target, at).wants_gaussian(rules));
    at.rgb[0] = target.rgb[0] - 0.46f;
    CHECK(four(target, at).wants_gaussian(rules));
    at.rgb[0] = target.rgb[0] + 0.23f, at.rgb[1] = target.rgb[1] - 0.23f; // they do not cancel
    CHECK(four(target, at).wants_gaussian(rules));
}

TEST_CASE("insertion: without a known depth there is no Gaussian, and pixels that are not finite do not count")
{
    for (float const depth : {0.0f, -1.0f, none, infinity, -infinity})
        CHECK_FALSE(four({{1, 1, 1}, depth}, {{0, 0, 0}, 0, 0}).wants_gaussian(rules));
    CHECK_FALSE(CellSums{}.wants_gaussian(rules));
    CHECK_FALSE(four({{none, 1, 1}, 2}, {{0, 0, 0}, 0, 0}).wants_gaussian(rules));
    CHECK_FALSE(four({{1, infinity, 1}, 2}, {{0, 0, 0}, 0, 0}).wants_gaussian(rules));

    // One pixel of four has a depth: it is the cell's. Colours are the mean of the pixels that count.
    CellSums one;
    one.add({{1, 1, 1}, 0}, {{0, 0, 0}, 0, 0});
    one.add({{0.5f, 0, 1}, 3}, {{0, 0, 0}, 0, 0});
    one.add({{0, 0.5f, 1}, none}, {{0, 0, 0}, 0, 0});
    one.add({{none, 0, 0}, 7}, {{0, 0, 0}, 0, 0});
    CHECK(one.pixels == 3);
    CHECK(one.deep == 1);
    CHECK(one.wants_gaussian(rules));
    CHECK(one.mean_depth() == 3);
    auto const g = splat::map::gaussian_of_cell(one, support::lens(8, 8), CellGrid::of(8, 8, 2), 0, 0, 1, rules);
    CHECK(g.colour[0] == 0.5f);
    CHECK(g.colour[1] == 0.5f);
    CHECK(g.colour[2] == 1);
}

TEST_CASE("insertion: a new Gaussian projects to the middle of its cell, with half a cell's deviation")
{
    for (auto const& [width, height, cell] :
         {std::tuple{64u, 48u, 2u}, std::tuple{63u, 47u, 2u}, std::tuple{65u, 50u, 4u}, std::tuple{5u, 3u, 8u}}) {
        auto const grid = CellGrid::of(width, height, cell);
        CHECK(grid.columns * cell >= width);
        CHECK((grid.columns - 1) * cell < width);
        CHECK((grid.rows - 1) * cell < height);
        auto camera = support::lens(width, height, 0.3f);
        camera.position[0] = 0.25f, camera.position[1] = -1, camera.position[2] = 3;
        Rules plain;
        plain.dilation = 0;
        auto const view = make_view(camera, plain);
        for (auto const& [column, row] :
             {std::pair{0u, 0u}, std::pair{grid.columns - 1, grid.rows - 1}, std::pair{grid.columns / 2, grid.rows / 2}}) {
            auto const sums = four({{0.25f, 0.5f, -0.1f}, 2.5f}, {{0, 0, 0}, 0, 0});
            InsertRules r;
            r.cell = cell;
            auto const g = splat::map::gaussian_of_cell(sums, camera, grid, column, row, 3, r);
            float const x1 = std::fmin(float((column + 1) * cell), float(width)), y1 = std::fmin(float((row + 1) * cell), float(height));
            auto const s = project(g, view, TileSize{width, height});
            REQUIRE(s.visible());
            CHECK(std::fabs(s.mean_px[0] + camera.cx - 0.5f * (float(column * cell) + x1)) < 1e-4f * x1);
            CHECK(std::fabs(s.mean_px[1] + camera.cy - 0.5f * (float(row * cell) + y1)) < 1e-4f * y1);
            CHECK(s.depth() == doctest::Approx(2.5).epsilon(1e-5));
            CHECK(std::exp(g.log_scale[0]) * camera.fx / 2.5f == doctest::Approx(0.5 * cell).epsilon(1e-5));
            CHECK(g.log_scale[1] == g.log_scale[0]);
            CHECK(g.log_scale[2] == g.log_scale[0]);
            CHECK(g.opacity == doctest::Approx(1 / (1 + std::exp(-1.0))));
            CHECK(g.rotation[0] == 1);
            CHECK(g.colour[1] == 0.5f);
            CHECK(g.colour[2] == 0); // no colour below 0
            CHECK(static_cast<std::uint32_t>(g.id) == (3u << 20 | (row * grid.columns + column + 1)));
        }
    }
}

TEST_CASE("insertion: ids are of one cell and keyframe alone, up to the last")
{
    std::set<std::uint32_t> ids;
    for (std::uint32_t const keyframe : {1u, 2u, splat::map::most_keyframes})
        for (std::uint32_t const cell : {0u, 1u, splat::map::most_cells - 1})
            ids.insert(static_cast<std::uint32_t>(splat::map::id_of_cell(keyframe, cell)));
    CHECK(ids.size() == 9);
    CHECK(ids.count(0) == 0);
    CHECK(*ids.begin() > splat::map::most_cells); // rows of a map that was read come before
    CHECK(*ids.rbegin() == 0xffffffffu);
}

TEST_CASE("removal: faint, huge and broken Gaussians go, at the bounds")
{
    RemoveRules const r;
    auto const sound = support::ball(1, 0, 0, 0.5f, 0.5f);
    float const scene = 4;
    CHECK_FALSE(splat::map::is_removed(sound, r, scene));
    auto g = sound;
    g.opacity = 0.0181f;
    CHECK_FALSE(splat::map::is_removed(g, r, scene));
    g.opacity = 0.0179f;
    CHECK(splat::map::is_removed(g, r, scene));
    for (int i = 0; i < 3; ++i) {
        g = sound;
        g.log_scale[i] = std::log(1.199f);
        CHECK_FALSE(splat::map::is_removed(g, r, scene));
        g.log_scale[i] = std::log(1.201f);
        CHECK(splat::map::is_removed(g, r, scene));
        for (float const bad : {none, infinity, -infinity}) {
            g = sound;
            g.log_scale[i] = bad;
            CHECK(splat::map::is_removed(g, r, scene));
            g = sound;
            g.mean_world[i] = bad;
            CHECK(splat::map::is_removed(g, r, scene));
        }
    }
    g = sound;
    g.opacity = none;
    CHECK(splat::map::is_removed(g, r, scene));
}
