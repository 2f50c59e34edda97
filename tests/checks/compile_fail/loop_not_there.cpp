// EXPECT: the program has no Loop around this step .*use get_step
#include <tilemesh/machine/tile.hpp>

struct Nothing {
    void operator()() const noexcept {}
};
using Program = tilemesh::Sequence<tilemesh::Superstep<Nothing>>;

void more(Program& program)
{
    tilemesh::get_loop<Nothing>(program).at_most = 2;
}
