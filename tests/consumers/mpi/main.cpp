// The program of ../small on the ranks of MPI.
#include <iostream>
#include <tilemesh/mpi/mpi_mesh.hpp>

struct Count { std::uint32_t seen; };
struct Ring : tilemesh::Channel<std::uint32_t, 1> {};
struct Pass {
    void operator()(Count& count, tilemesh::In<Ring> in, tilemesh::Out<Ring> out) const noexcept
    {
        for (auto d : tilemesh::news)
            for (std::uint32_t neighbour : in[d]) count.seen += neighbour;
        for (auto d : tilemesh::news) out[d].unchecked_push(1);
    }
};
using Program = tilemesh::Sequence<tilemesh::Repeat<Pass>>;

static void run()
{
    tilemesh::MpiMesh<Program> mesh{MPI_COMM_WORLD, Program{{3}}, tilemesh::Grid{4, 3}};
    auto const run = mesh.run();
    if (mesh.rank() == 0)
        std::cout << "exchanges " << run.exchanges() << '\n'
                  << "messages " << run.messages() << '\n'
                  << "seen " << mesh.state<Count>(mesh.grid().tile(0)).seen << '\n';
}
int main(int argc, char** argv)
{
    int level = MPI_THREAD_SINGLE;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &level);
    run();
    MPI_Finalize();
}
