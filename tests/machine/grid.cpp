#include <algorithm>
#include <cstdint>
#include <doctest/doctest.h>
#include <tilemesh/machine/grid.hpp>
#include <vector>

using namespace tilemesh;

namespace {

constexpr bool opposite_is_an_involution()
{
    for (Direction d : news)
        if (opposite(d) == d || opposite(opposite(d)) != d) return false;
    return opposite(Direction::north) == Direction::south && opposite(Direction::east) == Direction::west;
}
static_assert(opposite_is_an_involution());

constexpr bool indices_are_dense()
{
    for (std::uint32_t i = 0; i < 4; ++i)
        if (index(news[i]) != i) return false;
    return true;
}
static_assert(indices_are_dense());
static_assert(along_row[0] == Direction::east && along_row[1] == Direction::west);
static_assert(along_column[0] == Direction::north && along_column[1] == Direction::south);

// A tile id is one word. The largest coordinates do not overlap in it.
static_assert(sizeof(TileId) == 4 && TileId{}.packed == 0);
static_assert(TileId::at(65535, 0).x() == 65535 && TileId::at(65535, 0).y() == 0);
static_assert(TileId::at(0, 65535).x() == 0 && TileId::at(0, 65535).y() == 65535);
static_assert(TileId::at(39, 35).packed == (39u | 35u << 16));
static_assert(TileId::at(1, 2) == TileId{0x00020001u} && TileId::at(1, 2) != TileId::at(2, 1));

static_assert(Grid{}.width == 40 && Grid{}.height == 36 && Grid{}.size() == 1440, "the paper's grid");

/// Calls f(tile) for each tile of a grid, in index order.
template <class F>
constexpr bool for_all(Grid grid, F f)
{
    for (std::uint32_t i = 0; i < grid.size(); ++i)
        if (!f(grid.tile(i), i)) return false;
    return true;
}

constexpr bool packs_in_row_order(Grid grid)
{
    return for_all(grid, [grid](TileId t, std::uint32_t i) {
        return grid.index_of(t) == i && t.x() == i % grid.width && t.y() == i / grid.width && t.x() < grid.width &&
               t.y() < grid.height;
    });
}
static_assert(packs_in_row_order({1, 1}) && packs_in_row_order({1, 5}) && packs_in_row_order({5, 1}) &&
              packs_in_row_order({3, 2}) && packs_in_row_order({40, 36}));

/// An edge reflects to the tile itself, on the same side. Inside the grid a neighbour is one step away, and its opposite side leads back.
constexpr bool neighbours_are_right(Grid grid)
{
    return for_all(grid, [grid](TileId t, std::uint32_t) {
        for (Direction d : news) {
            auto const n = grid.neighbour(t, d);
            auto const dx = static_cast<int>(n.x()) - static_cast<int>(t.x());
            auto const dy = static_cast<int>(n.y()) - static_cast<int>(t.y());
            bool const edge = (d == Direction::north && t.y() == 0) || (d == Direction::west && t.x() == 0) ||
                              (d == Direction::south && t.y() == grid.height - 1) ||
                              (d == Direction::east && t.x() == grid.width - 1);
            if (grid.has_neighbour(t, d) == edge) return false;
            if (edge) {
                if (n != t || grid.arrival(t, d) != d) return false;
                continue;
            }
            int const want_x = d == Direction::east ? 1 : d == Direction::west ? -1 : 0;
            int const want_y = d == Direction::south ? 1 : d == Direction::north ? -1 : 0;
            if (dx != want_x || dy != want_y) return false;
            if (grid.arrival(t, d) != opposite(d) || grid.neighbour(n, opposite(d)) != t) return false;
        }
        return true;
    });
}
static_assert(neighbours_are_right({1, 1}) && neighbours_are_right({1, 5}) && neighbours_are_right({5, 1}) &&
              neighbours_are_right({3, 2}) && neighbours_are_right({40, 36}));

/// With Edge::wrap the grid is a torus: each side leads to a tile whose opposite side leads back. Edge::reflect and Edge::drop have the
/// neighbours of a call without an edge.
constexpr bool edges_are_right(Grid grid)
{
    return for_all(grid, [grid](TileId t, std::uint32_t) {
        for (Direction d : news) {
            auto const n = grid.neighbour(t, d, Edge::wrap);
            auto const x = (t.x() + grid.width + (d == Direction::east ? 1 : 0) - (d == Direction::west ? 1 : 0)) % grid.width;
            auto const y = (t.y() + grid.height + (d == Direction::south ? 1 : 0) - (d == Direction::north ? 1 : 0)) % grid.height;
            if (n != TileId::at(x, y) || grid.arrival(t, d, Edge::wrap) != opposite(d)) return false;
            if (grid.neighbour(n, opposite(d), Edge::wrap) != t) return false;
            for (Edge edge : {Edge::reflect, Edge::drop})
                if (grid.neighbour(t, d, edge) != grid.neighbour(t, d) || grid.arrival(t, d, edge) != grid.arrival(t, d)) return false;
            if (grid.delivers(t, d, Edge::drop) != grid.has_neighbour(t, d)) return false;
            if (!grid.delivers(t, d, Edge::reflect) || !grid.delivers(t, d, Edge::wrap)) return false;
        }
        return true;
    });
}
static_assert(edges_are_right({1, 1}) && edges_are_right({1, 5}) && edges_are_right({5, 1}) && edges_are_right({2, 2}) &&
              edges_are_right({5, 3}) && edges_are_right({17, 11})); // Clang 14 cannot evaluate a larger grid at compile time

/// For each end of each tile: the number of outgoing ends that are read there.
std::vector<int> readers(Grid grid)
{
    std::vector<int> count(std::size_t{4} * grid.size(), 0);
    for (std::uint32_t i = 0; i < grid.size(); ++i)
        for (Direction d : news) {
            auto const t = grid.tile(i);
            ++count[4 * grid.index_of(grid.neighbour(t, d)) + index(grid.arrival(t, d))];
        }
    return count;
}

} // namespace

TEST_CASE("every outgoing end is read in exactly one place: no two senders write one slot")
{
    for (Grid const grid : {Grid{1, 1}, Grid{1, 5}, Grid{5, 1}, Grid{3, 2}, Grid{2, 2}, Grid{40, 36}}) {
        CAPTURE(grid.width);
        CAPTURE(grid.height);
        auto const count = readers(grid);
        CHECK(count.size() == 4 * grid.size());
        CHECK(std::all_of(count.begin(), count.end(), [](int n) { return n == 1; }));
    }
}
