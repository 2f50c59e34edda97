// The tests of the MPI engine: every rank runs every test case, and compares its own tiles with a Mesh of the whole grid.
#define DOCTEST_CONFIG_IMPLEMENT
#include "../engine/programs.hpp"
#include "on_ranks.hpp"
#include <iostream>
#include <mpi.h>
#include <unistd.h>

namespace {
/// A run in which the last rank dies in superstep 5. The launcher must end the other ranks.
void die()
{
    using namespace engine_test;
    MpiMesh<Heat> mesh{MPI_COMM_WORLD, Heat{{1000}}, Grid{4, 8}};
    mesh.observe([&](SuperstepEvent const& e) {
        if (e.pass == 4) std::fprintf(stderr, "rank %u is in superstep 4\n", mesh.rank());
        if (e.pass == 5 && mesh.rank() + 1 == mesh.ranks()) ::_exit(3);
        if (e.pass == 100) std::fprintf(stderr, "rank %u goes on\n", mesh.rank());
    });
    mesh.run();
}
} // namespace

int main(int argc, char** argv)
{
    int level = MPI_THREAD_SINGLE;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &level);
    if (argc == 2 && std::strcmp(argv[1], "--die") == 0) die();
    doctest::Context context(argc, argv);
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    if (rank != 0) context.setOption("minimal", true); // only what fails, and the summary of rank 0
    int failed = context.run();
    // A rank that stops at its first failure ends the job, because the other ranks would wait for its messages.
    bool const stops = std::any_of(argv, argv + argc, [](char const* word) { return std::strncmp(word, "-aa=", 4) == 0; });
    if (stops && failed != 0) {
        std::cout.flush();
        MPI_Abort(MPI_COMM_WORLD, failed);
    }
    failed += mpi_test::requests_left();
    if (mpi_test::requests_left() != 0) std::fprintf(stderr, "rank %d leaves %d requests\n", rank, mpi_test::requests_left());
    MPI_Finalize();
    return failed;
}
