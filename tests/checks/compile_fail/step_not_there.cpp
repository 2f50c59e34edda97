// EXPECT: the program has no such step .*name a kernel that it runs
#include <tilemesh/machine/tile.hpp>

struct Nothing {
    void operator()() const noexcept {}
};
struct Other {
    void operator()() const noexcept {}
};
using Program = tilemesh::Sequence<tilemesh::Superstep<Nothing>>;

void more(Program& program)
{
    (void)tilemesh::get_step<Other>(program);
}
