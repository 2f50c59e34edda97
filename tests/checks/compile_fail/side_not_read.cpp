// EXPECT: a channel that receives nothing from this side
#include <tilemesh/machine/tile.hpp>

struct Row : tilemesh::Channel<float, 1, tilemesh::Edge::wrap, tilemesh::Sides::west> {};
struct Step {
    void operator()(tilemesh::In<Row> in, tilemesh::Out<Row>) const noexcept { (void)in.from<tilemesh::Direction::west>().size(); }
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
