// EXPECT: unknown kernel parameter .*change this parameter to one of them
#include <tilemesh/machine/tile.hpp>

struct Cell {
    float heat;
};
struct Step {
    void operator()(Cell) const noexcept {}
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
