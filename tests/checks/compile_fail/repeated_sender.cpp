// EXPECT: only sends on channel C while C still holds unread mail
#include <tilemesh/machine/tile.hpp>

struct Cell {
    float heat;
};
struct Wire : tilemesh::Channel<Cell, 4> {};
struct Send {
    void operator()(tilemesh::Out<Wire>) const noexcept {}
};
struct Read {
    void operator()(tilemesh::In<Wire>) const noexcept {}
};
using Program = tilemesh::Sequence<tilemesh::Repeat<Send>, tilemesh::Superstep<Read>>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
