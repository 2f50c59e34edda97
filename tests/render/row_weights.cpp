// The work of the rows of tiles, counted against a loop over all tiles and splats.
#include "../splat/support.hpp"
#include <tilemesh/mpi/bands.hpp>
#include <tilemesh/render/ranks/row_weights.hpp>
#include <tilemesh/splat/projection.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
using render::RowWeights;

namespace {
/// Counts the tiles of each row that the rectangle of a splat meets, tile by tile.
void count_slowly(Splat const& s, Tiling const& tiling, std::vector<std::uint32_t>& rows)
{
    if (!s.visible()) return;
    auto const r = s.rect();
    for (std::uint32_t y = 0; y < tiling.rows; ++y)
        for (std::uint32_t x = 0; x < tiling.columns; ++x)
            if (r.x0 < (x + 1) * tiling.tile_width && r.x1 > x * tiling.tile_width && r.y0 < (y + 1) * tiling.tile_height && r.y1 > y * tiling.tile_height)
                ++rows[y];
}
} // namespace

TEST_CASE("the work of a row is its tiles with pixels, and the tiles that each splat touches")
{
    auto const tiling = make_tiling(100, 70, 12, 8); // 9 x 9 tiles
    auto const view = make_view(support::lens(100, 70), {});
    std::uint32_t const height = 12; // the last 3 rows of the grid have no pixels
    RowWeights rows(tiling, height), without_tiles(tiling, height);
    rows.add_tiles();
    std::vector<std::uint32_t> wanted(height);
    for (std::uint32_t y = 0; y < tiling.rows; ++y) wanted[y] = tiling.columns;
    CHECK(rows.weights() == wanted);
    std::uint32_t visible = 0;
    for (auto const& g : support::cloud(300, 5)) {
        auto const s = project(g, view, tiling);
        visible += s.visible() ? 1 : 0;
        rows.add(s);
        without_tiles.add(s);
        count_slowly(s, tiling, wanted);
    }
    CHECK(visible > 50);
    CHECK(visible < 300);
    CHECK(rows.weights() == wanted);
    CHECK(rows.weights()[tiling.rows] == 0);
    for (std::uint32_t y = 0; y < tiling.rows; ++y) CHECK(rows.work()[y] == without_tiles.work()[y] + tiling.columns);
}

TEST_CASE("work above 32 bits becomes smaller by one power of two; a row with work keeps some")
{
    RowWeights rows(make_tiling(8, 40, 8, 8), 5);
    rows.work() = {0xffffffffu, 0, 1, 2, 0xfffffffeu};
    CHECK(rows.weights() == std::vector<std::uint32_t>{0xffffffffu, 0, 1, 2, 0xfffffffeu});
    rows.work() = {0x100000000u, 0, 1, 2, 7};
    CHECK(rows.weights() == std::vector<std::uint32_t>{0x80000000u, 0, 1, 1, 3});
    rows.work() = {~std::uint64_t{0}, std::uint64_t{1} << 40, 1, 0, 0};
    CHECK(rows.weights() == std::vector<std::uint32_t>{0xffffffffu, 0x100u, 1, 0, 0});
}

TEST_CASE("bands of this work: a row with most splats is a band of its own")
{
    auto const tiling = make_tiling(80, 80, 8, 8); // 10 x 10 tiles
    RowWeights rows(tiling, 10);
    rows.add_tiles();
    auto const view = make_view(support::lens(80, 80), {});
    auto g = support::cloud(1, 1).front();
    for (auto& m : g.mean_world) m = 0;
    g.mean_world[1] = 0.17f; // in the middle of a row of tiles
    g.mean_world[2] = 2;
    for (auto& s : g.log_scale) s = -6;
    g.opacity = 0.5f;
    auto const s = project(g, view, tiling);
    REQUIRE(s.visible());
    for (int n = 0; n < 1000; ++n) rows.add(s);
    mpi::Bands const bands{10, 3, rows.weights()};
    auto const busy = bands.rank_of(s.anchor.y());
    CHECK(tiles_of(s, tiling).first.y() == tiles_of(s, tiling).last.y());
    CHECK(bands.last(busy) - bands.first(busy) == 1);
}
