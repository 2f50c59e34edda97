// EXPECT: a state.s capacity is part of the layout; give the Buffer a number
#include <tilemesh/machine/tile.hpp>

struct Cell {
    float heat;
};
struct Pile : tilemesh::Buffer<Cell> {};
struct Step {
    void operator()(Pile& pile) const noexcept { pile.truncate(0); }
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
