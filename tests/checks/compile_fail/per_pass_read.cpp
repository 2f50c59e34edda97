// EXPECT: a kernel reads per_pass statistics of another pass .*keep words that kernels read in another state
#include <tilemesh/machine/tile.hpp>

struct Passed {
    static constexpr bool per_pass = true;
    std::uint32_t hops;
};
struct Step {
    void operator()(Passed const&) const noexcept {}
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
