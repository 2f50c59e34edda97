// The heat equation on 40 x 36 tiles, on the ranks of MPI: mpirun -n 4 on_ranks. Every number of ranks prints the same.
#include "../heat/heat.hpp"
#include <cmath>
#include <cstdio>
#include <numbers>
#include <tilemesh/mpi/mpi_mesh.hpp>
namespace {
int run()
{
    tilemesh::MpiMesh mesh{MPI_COMM_WORLD, tilemesh::Repeat<Diffuse>{1001}, tilemesh::Grid{40, 36}}; // the first pass only sends
    mesh.broadcast<Conductivity>().per_step = 0.2f;                                                  // a run takes that of rank 0
    auto const wave = [](tilemesh::TileId tile) { return 100 * std::cos(std::numbers::pi * (tile.x() + 0.5) / 40); };
    for (auto [tile, cell] : mesh.states<Cell>()) cell.kelvin = static_cast<float>(300 + wave(tile)); // the tiles of this rank
    auto const counters = mesh.run();
    mesh.gather<Cell>();
    if (mesh.rank() != 0) return 0;
    double worst = 0, fade = std::pow(1 - 2 * 0.2 * (1 - std::cos(std::numbers::pi / 40)), 1000); // of one cosine from west to east
    for (auto tile : mesh.grid().tiles())
        worst = std::fmax(worst, std::fabs(mesh.state<Cell>(tile).kelvin - (300 + fade * wave(tile))));
    std::printf("%.0f messages; the wave fades to %.4f of its height, off by at most %.4f K\n", static_cast<double>(counters.messages()), fade,
                worst);
    return worst < 0.01 ? 0 : 1;
}
} // namespace
int main(int argc, char** argv)
{
    int level = MPI_THREAD_SINGLE;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &level);
    auto const failed = run(); // the mesh ends before MPI does
    MPI_Finalize();
    return failed;
}
