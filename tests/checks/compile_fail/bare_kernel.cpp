// EXPECT: not a program .*wrap the kernel in one of them
#include <tilemesh/machine/tile.hpp>

struct Cell {
    float heat;
};
struct Step {
    void operator()(Cell& cell) const noexcept { cell.heat = 0; }
};
using Program = tilemesh::Sequence<tilemesh::Superstep<Step>, Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
