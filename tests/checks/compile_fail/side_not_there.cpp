// EXPECT: a message to a side that the channel does not have
#include <tilemesh/machine/tile.hpp>

struct Row : tilemesh::Channel<float, 1, tilemesh::Edge::wrap, tilemesh::Sides::west> {};
struct Step {
    void operator()(tilemesh::In<Row>, tilemesh::Out<Row> out) const noexcept { out.to<tilemesh::Direction::east>().push(1.0f); }
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
