// EXPECT: not a program .*wrap the kernel in one of them
#include <tilemesh/engine/mesh.hpp>

struct Cell {
    float heat;
};
struct Step {
    void operator()(Cell& cell) const noexcept { cell.heat = 0; }
};

int main()
{
    tilemesh::Mesh mesh{Step{}, tilemesh::Grid{2, 2}};
    mesh.run();
}
