// EXPECT: a channel that skips tiles and whose edges reflect or wrap
#include <tilemesh/machine/tile.hpp>

struct Express : tilemesh::Channel<float, 1, tilemesh::Edge::wrap, tilemesh::Sides::all, 4> {};
struct Step {
    void operator()(tilemesh::In<Express>, tilemesh::Out<Express>) const noexcept {}
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
