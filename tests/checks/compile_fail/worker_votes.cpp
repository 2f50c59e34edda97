// EXPECT: a kernel that takes Worker may neither send nor vote
#include <tilemesh/machine/tile.hpp>

struct Cell {
    float heat;
};
struct Step {
    tilemesh::Vote operator()(Cell&, tilemesh::Worker) const noexcept { return tilemesh::Vote::quiet; }
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
