// EXPECT: a kernel's operations is one function .it is overloaded, a template or private
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
    static tilemesh::Operations<Counting> operations() noexcept { return {}; }
    static tilemesh::Operations<Counting> operations(Cell const&) noexcept { return {}; }
};

int main()
{
    tilemesh::Mesh mesh{tilemesh::Superstep<Step>{}, tilemesh::Grid{2, 2}}; // not Traced
    mesh.run();
}
