#pragma once
#include "options.hpp"

namespace scaling {

/// With the argument --ranks, MPI is initialised as long as this lives, and only rank 0 prints.
class OnRanks {
public:
    OnRanks(int argc, char** argv);
    ~OnRanks();
    OnRanks(OnRanks const&) = delete;
    OnRanks& operator=(OnRanks const&) = delete;

private:
    [[maybe_unused]] bool on_ = false;
};

/// Measures MpiMesh over ranks and threads. Collective. Returns the exit status. Throws Error in a build without MPI.
int run_on_ranks(Options const& options);
/// Measures whole frames over ranks and threads. Collective. Returns the exit status. Only in a build with MPI.
int frames_on_ranks(Options const& options);

} // namespace scaling
