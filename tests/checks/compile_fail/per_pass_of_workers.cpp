// EXPECT: a kernel that takes Worker may not fill per_pass statistics .*count in a superstep of one worker
#include <tilemesh/machine/tile.hpp>

struct Passed {
    static constexpr bool per_pass = true;
    std::uint32_t hops;
};
struct Step {
    void operator()(Passed&, tilemesh::Worker) const noexcept {}
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
