// EXPECT: no machine .*a setup is not one: give its Machine
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/splat/setup_types.hpp>

struct Cell {
    float heat;
};
struct Step {
    void operator()(Cell& cell) const noexcept { cell.heat = 0; }
};

int main()
{
    tilemesh::Mesh mesh{tilemesh::Superstep<Step>{}, tilemesh::Grid{2, 2}, tilemesh::splat::Lossless{}};
    mesh.run();
}
