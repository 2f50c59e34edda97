// A frame over the ranks of MPI: `mpirun -n 4 frame_on_ranks`. Rank 0 gets the picture, every rank the report.
#include <iostream>
#include <mpi.h>
#include <tilemesh/render/ranks/host.hpp>
#include <tilemesh/mpi/mpi_mesh.hpp>
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/scene/built_in.hpp>

int main(int argc, char** argv)
{
    MPI_Init(&argc, &argv);
    {
        auto const map = tilemesh::scene::built_in_map();
        auto const camera = tilemesh::scene::built_in_camera({640, 360});
        tilemesh::BasicRenderer<tilemesh::splat::Lossless, tilemesh::MpiMesh> renderer{map}; // on MPI_COMM_WORLD
        auto const frame = renderer.render(camera);
        if (renderer.mesh().rank() == 0) {
            tilemesh::report::write_pfm("frame.pfm", frame.image);
            std::cout << frame.report;
        }
    } // the renderer goes before MPI_Finalize
    MPI_Finalize();
}
