// EXPECT: a channel is not state .*take In<C> or Out<C> by value
#include <tilemesh/machine/tile.hpp>

struct Cell {
    float heat;
};
struct Wire : tilemesh::Channel<Cell, 4> {};
struct Step {
    void operator()(Wire&) const noexcept {}
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
