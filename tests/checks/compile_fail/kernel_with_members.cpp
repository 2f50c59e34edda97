// EXPECT: a kernel must be an empty class .*Broadcast<P>
#include <tilemesh/machine/tile.hpp>

struct Cell {
    float heat;
};
struct Step {
    float rate = 1;
    void operator()(Cell& cell) const noexcept { cell.heat *= rate; }
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
