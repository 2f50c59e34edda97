// EXPECT: the program does not fit in a tile's SRAM
// EXPECT: SramBudget<.*TestMachine<1024.*, Pile, 1008U?, 12U?>
#include <tilemesh/machine/tile.hpp>

// 1,024 bytes: 7 words of cell, and a pile of 250 words and its head. Twelve bytes too many, and the pile is the largest.
struct Cell {
    float part[7];
};
struct Pile : tilemesh::Buffer<float, 250> {};
struct Step {
    void operator()(Cell&, Pile& pile) const noexcept { pile.truncate(0); }
};

static_assert(tilemesh::Tile<tilemesh::TestMachine<1036>, tilemesh::Superstep<Step>>::bytes == 1036); // fits exactly
static_assert(tilemesh::Tile<tilemesh::TestMachine<1024>, tilemesh::Superstep<Step>>::bytes == 1036);
