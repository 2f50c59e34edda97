// EXPECT: a tile.s state is a Buffer or a trivially copyable struct of whole 32-bit words .*; keep a double or a 64-bit integer as two words
#include <tilemesh/machine/tile.hpp>

struct Cell {
    double heat;
};
struct Step {
    void operator()(Cell& cell) const noexcept { cell.heat = 0; }
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
