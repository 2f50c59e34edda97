// In place of on_ranks.cpp, in a build without MPI.
#include "scaling.hpp"
#include <tilemesh/error.hpp>

namespace scaling {

OnRanks::OnRanks(int, char**) {}
OnRanks::~OnRanks() = default;

int run_on_ranks(Options const&)
{
    throw tilemesh::Error("option --ranks (this program was built without MPI); configure with -DTILEMESH_MPI=ON, and build it again");
}

} // namespace scaling
