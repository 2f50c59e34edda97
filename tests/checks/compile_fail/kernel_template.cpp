// EXPECT: exactly one operator\(\), neither overloaded nor a template
#include <tilemesh/machine/tile.hpp>

struct Step {
    template <class Cell>
    void operator()(Cell& cell) const noexcept
    {
        cell.heat = 0;
    }
};
using Program = tilemesh::Superstep<Step>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
