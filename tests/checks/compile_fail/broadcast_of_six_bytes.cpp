// EXPECT: Broadcast<P>: P is copied to every tile
#include <tilemesh/machine/tile.hpp>

struct Rate {
    std::uint16_t part[3];
};
struct Step {
    void operator()(tilemesh::Broadcast<Rate>) const noexcept {}
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
