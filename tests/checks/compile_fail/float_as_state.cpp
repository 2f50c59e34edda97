// EXPECT: a tile's state is a struct of the program
#include <tilemesh/machine/tile.hpp>

struct Step {
    void operator()(float& heat) const noexcept { heat = 0; }
};

static_assert(tilemesh::Tile<tilemesh::Mk2, tilemesh::Superstep<Step>>::bytes > 0);
