// EXPECT: the flag of an If is a pointer to a std::uint32_t member of a broadcast .*give it If<&Parameters::flag, \.\.\.>
#include <tilemesh/machine/tile.hpp>

struct Rate {
    float rate;
};
struct Nothing {
    void operator()() const noexcept {}
};
using Program = tilemesh::If<&Rate::rate, tilemesh::Superstep<Nothing>>;

static_assert(tilemesh::StepTraits<Program>::Steps::count == 1);
