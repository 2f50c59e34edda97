// EXPECT: a tile.s state is a Buffer or a trivially copyable struct of whole 32-bit words
#include <tilemesh/machine/tile.hpp>

struct Cell {
    std::uint16_t part[3];
};
struct Step {
    void operator()(Cell& cell) const noexcept { cell.part[0] = 0; }
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
