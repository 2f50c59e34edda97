// EXPECT: an item is copied by the exchange fabric: .*whole 32-bit words
#include <tilemesh/machine/tile.hpp>

struct Message {
    std::uint16_t part[3];
};
struct Wire : tilemesh::Channel<Message, 4> {};
struct Step {
    void operator()(tilemesh::In<Wire>, tilemesh::Out<Wire>) const noexcept {}
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
