// A frame of the built-in map, on the ranks of MPI: mpirun -n 4 frame_on_ranks [MAP.ply]. Every number of ranks makes the same picture.
#include <iostream>
#include <tilemesh/mpi/mpi_mesh.hpp>
#include <tilemesh/tilemesh.hpp>
namespace {
void run(char const* file)
{
    auto const map = file != nullptr ? tilemesh::scene::load_ply(file) : tilemesh::scene::built_in_map();
    auto const camera = tilemesh::scene::frame_whole(map, {640, 360});

    tilemesh::BasicRenderer<tilemesh::splat::Lossless, tilemesh::MpiMesh> renderer{map}; // on the ranks of MPI_COMM_WORLD
    auto const frame = renderer.render(camera);

    if (renderer.mesh().rank() != 0) return; // rank 0 has the picture
    tilemesh::report::write_pfm("frame_on_ranks.pfm", frame.image);
    std::cout << frame.report;
}
} // namespace
int main(int argc, char** argv)
{
    int level = MPI_THREAD_SINGLE;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &level);
    int failed = 0;
    try {
        run(argc > 1 ? argv[1] : nullptr); // the renderer ends before MPI does
    } catch (tilemesh::Error const& e) {   // the same on every rank
        int rank = 0;
        MPI_Comm_rank(MPI_COMM_WORLD, &rank);
        if (rank == 0) std::cerr << e.what() << '\n';
        failed = 2;
    }
    MPI_Finalize();
    return failed;
}
