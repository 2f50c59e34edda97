// EXPECT: a set of operations has no names .*static constexpr char const\* names
#include <tilemesh/machine/operations.hpp>

enum class Sorting : unsigned { compare, swap };
struct Cell {
    float heat;
};
struct Step {
    void operator()(Cell& cell) const noexcept { cell.heat += 1; }
    static tilemesh::Operations<Sorting> operations(Cell const&) noexcept { return {}; }
};

static_assert(tilemesh::operation_names<Step>().size == 2);
tilemesh::Operations<Sorting> counted;
