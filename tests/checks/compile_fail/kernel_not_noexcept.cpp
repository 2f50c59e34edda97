// EXPECT: const noexcept \(tiles have no exceptions\); add noexcept
#include <tilemesh/machine/tile.hpp>

struct Cell {
    float heat;
};
struct Step {
    void operator()(Cell& cell) const { cell.heat = 0; }
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
