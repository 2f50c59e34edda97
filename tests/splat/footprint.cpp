// test: without tsan
#include "support.hpp"
#include <tilemesh/splat/footprint.hpp>
#include <tilemesh/splat/policies.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;

namespace {
/// Every tile of the rectangle except the anchor has exactly one parent. The parent lies in the rectangle and is nearer to the anchor.
constexpr bool is_tree(std::uint32_t width, std::uint32_t height, TileId anchor)
{
    Grid const grid{width, height};
    for (std::uint32_t i = 0; i < grid.size(); ++i) {
        auto const t = grid.tile(i);
        std::uint32_t parents = 0;
        for (Direction d : news) {
            if (!grid.has_neighbour(t, d)) continue;
            auto const p = grid.neighbour(t, d);
            if (!is_child(anchor, p, opposite(d))) continue;
            ++parents;
            auto const far = [&](TileId a) {
                return (a.x() > anchor.x() ? a.x() - anchor.x() : anchor.x() - a.x()) +
                       (a.y() > anchor.y() ? a.y() - anchor.y() : anchor.y() - a.y());
            };
            if (far(p) + 1 != far(t)) return false;
        }
        if (parents != (t == anchor ? 0u : 1u)) return false;
    }
    return true;
}
constexpr bool is_tree_for_all_anchors(std::uint32_t width, std::uint32_t height)
{
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x)
            if (!is_tree(width, height, TileId::at(x, y))) return false;
    return true;
}
static_assert(is_tree_for_all_anchors(1, 1) && is_tree_for_all_anchors(5, 1) && is_tree_for_all_anchors(1, 5) &&
                  is_tree_for_all_anchors(4, 3) && is_tree_for_all_anchors(6, 6),
              "bloom reaches every tile of a footprint once and never cycles");

static_assert(is_dimension_ordered<RowFirst>());
struct Wanders { // turns back to the row after the column
    static constexpr Direction first_leg[2] = {Direction::west, Direction::east};
    static constexpr Direction towards(TileId from, TileId to) noexcept
    {
        if (to.x() != from.x() && (from.y() % 2 == 0 || to.y() == from.y()))
            return to.x() > from.x() ? Direction::east : Direction::west;
        return to.y() > from.y() ? Direction::south : Direction::north;
    }
};
static_assert(!is_dimension_ordered<Wanders>());
} // namespace

TEST_CASE("covers: a rectangle touches exactly the tiles that hold one of its pixels")
{
    Tiling const tiling = make_tiling(40, 30, 7, 5);
    support::Random random(3);
    for (int n = 0; n < 300; ++n) {
        Splat s{};
        auto const x0 = random.below(40), y0 = random.below(30);
        auto const x1 = x0 + 1 + random.below(40 - x0), y1 = y0 + 1 + random.below(30 - y0);
        s.columns = x0 | x1 << 16;
        s.rows = y0 | y1 << 16;
        for (std::uint32_t ty = 0; ty < tiling.rows + 1; ++ty)
            for (std::uint32_t tx = 0; tx < tiling.columns + 1; ++tx) {
                bool touches = false;
                for (auto y = y0; y < y1; ++y)
                    for (auto x = x0; x < x1; ++x) touches = touches || (x / 7 == tx && y / 5 == ty);
                if (covers(s, tiling, TileId::at(tx, ty)) != touches) FAIL("tile ", tx, ",", ty);
            }
    }
    CHECK_FALSE(covers(Splat{}, tiling, TileId::at(0, 0)));
}

TEST_CASE("tiles: half-open, every pixel of the frame on exactly one tile, partial tiles at the right and bottom")
{
    Camera camera = support::flat_camera(1283, 721);
    for (auto const& [w, h] : {std::pair{32u, 20u}, {7u, 13u}, {1283u, 721u}, {1u, 1u}, {24u, 24u}}) {
        auto const tiling = make_tiling(camera.width, camera.height, w, h);
        std::uint64_t pixels = 0;
        for (std::uint32_t y = 0; y < tiling.rows; ++y)
            for (std::uint32_t x = 0; x < tiling.columns; ++x) {
                auto const r = pixels_of(tiling, camera, TileId::at(x, y));
                CHECK(r.x0 == x * w);
                CHECK(r.x1 <= camera.width);
                CHECK_FALSE(r.empty());
                pixels += std::uint64_t{r.x1 - r.x0} * (r.y1 - r.y0);
            }
        CHECK(pixels == std::uint64_t{camera.width} * camera.height);
        CHECK(pixels_of(tiling, camera, TileId::at(tiling.columns, 0)).empty());
        CHECK(pixels_of(tiling, camera, TileId::at(0, tiling.rows)).empty());
    }
}
