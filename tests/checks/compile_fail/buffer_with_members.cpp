// EXPECT: a named buffer with members of its own
#include <tilemesh/machine/tile.hpp>

struct Pile : tilemesh::Buffer<float, 4> {
    float sum;
};
struct Step {
    void operator()(Pile& pile) const noexcept { pile.sum = 0; }
};

static_assert(tilemesh::Tile<tilemesh::Mk2, tilemesh::Superstep<Step>>::bytes > 0);
