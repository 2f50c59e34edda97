// EXPECT: a kernel's AllWorkers takes other parameters than the kernel
#include <tilemesh/engine/contract.hpp>
#include <tilemesh/engine/mesh.hpp>

struct Cell {
    float heat;
};
struct Step {
    void operator()(Cell&, tilemesh::Worker) const noexcept {}
    struct AllWorkers {
        void operator()(Cell&, tilemesh::Here, tilemesh::Worker) const noexcept {}
    };
};

void run()
{
    tilemesh::Mesh<tilemesh::Superstep<Step>>{{}, {2, 2}}.run();
}
