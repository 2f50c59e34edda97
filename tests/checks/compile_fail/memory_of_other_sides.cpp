// EXPECT: memory_of names a channel with other sides or another edge
#include <tilemesh/machine/tile.hpp>

struct Host : tilemesh::Channel<float, 4, tilemesh::Edge::wrap, tilemesh::Sides::west> {};
struct Guest : tilemesh::Channel<float, 4, tilemesh::Edge::wrap, tilemesh::Sides::north> {
    using memory_of = Host;
};
struct First {
    void operator()(tilemesh::In<Host>, tilemesh::Out<Host>) const noexcept {}
};
struct Second {
    void operator()(tilemesh::In<Guest>, tilemesh::Out<Guest>) const noexcept {}
};
using Program = tilemesh::Sequence<tilemesh::Superstep<First>, tilemesh::Superstep<Second>>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
