// EXPECT: a kernel's operations is .static Operations
#include <tilemesh/engine/mesh.hpp>

struct Counting {
    enum Kind : unsigned { heated };
    static constexpr char const* names[] = {"heated"};
};
struct Cell {
    float heat;
};
struct Other {
    float heat;
};
struct Step {
    void operator()(Cell& cell) const noexcept { cell.heat = 0; }
    tilemesh::Operations<Counting> operations(Cell const&) const noexcept { return {}; }
};

int main()
{
    tilemesh::Mesh mesh{tilemesh::Superstep<Step>{}, tilemesh::Grid{2, 2}}; // not Traced
    mesh.run();
}
