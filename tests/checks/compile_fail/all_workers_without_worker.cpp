// EXPECT: only a kernel that takes Worker may have AllWorkers
#include <tilemesh/engine/contract.hpp>
#include <tilemesh/engine/mesh.hpp>

struct Cell {
    float heat;
};
struct Step {
    void operator()(Cell&) const noexcept {}
    struct AllWorkers {
        void operator()(Cell&) const noexcept {}
    };
};

void run()
{
    tilemesh::Mesh<tilemesh::Superstep<Step>>{{}, {2, 2}}.run();
}
