// EXPECT: a kernel returns nothing or a Vote
#include <tilemesh/machine/tile.hpp>

struct Cell {
    float heat;
};
struct Step {
    int operator()(Cell&) const noexcept { return 0; }
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
