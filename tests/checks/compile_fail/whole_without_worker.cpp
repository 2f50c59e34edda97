// EXPECT: only a kernel that takes Worker may have a Whole
#include <tilemesh/engine/contract.hpp>
#include <tilemesh/engine/mesh.hpp>

struct Cell {
    float heat;
};
struct Step {
    void operator()(Cell&) const noexcept {}
    struct Whole {
        void operator()(Cell&) const noexcept {}
    };
};

void run()
{
    tilemesh::Mesh<tilemesh::Superstep<Step>>{{2, 2}}.run();
}
