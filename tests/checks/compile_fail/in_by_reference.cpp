// EXPECT: are views .*take them by value
#include <tilemesh/machine/tile.hpp>

struct Cell {
    float heat;
};
struct Wire : tilemesh::Channel<Cell, 4> {};
struct Step {
    void operator()(tilemesh::In<Wire>&, tilemesh::Out<Wire>) const noexcept {}
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
