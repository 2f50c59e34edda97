// EXPECT: const noexcept \(a kernel has no state of its own\); add const
#include <tilemesh/machine/tile.hpp>

struct Cell {
    float heat;
};
struct Step {
    void operator()(Cell& cell) noexcept { cell.heat = 0; }
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
