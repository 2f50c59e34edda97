#pragma once
#include <cstdint>
#include <mpi.h>
#include <string>
#include <vector>

/// The ranks of MPI that a bench runs on, and what they do in MPI.
namespace scaling {

/// What this rank did in MPI since the last look, counted between the engine and MPI (the profiling interface, PMPI).
struct Calls {
    double messages = 0, bytes = 0, agreements = 0, waiting_ms = 0;
};
extern Calls calls;

int world_rank();
std::uint32_t world_size();
/// Waits for all ranks, asleep: a rank that takes no part in a measurement leaves its core to the others.
void meet();
/// 1, 2, 4 ... ranks, and all.
std::vector<std::uint32_t> numbers_of_ranks();
/// A median with the 20 % and the 80 % quantile: "1.20 (1.10 to 1.30)".
std::string spread(std::vector<double> const& samples);

/// The first `ranks` ranks of the world. Collective over the world.
class Team {
public:
    explicit Team(std::uint32_t ranks) : ranks_(ranks)
    {
        MPI_Comm_split(MPI_COMM_WORLD, contains_me() ? 0 : MPI_UNDEFINED, world_rank(), &comm_);
    }
    ~Team()
    {
        if (contains_me()) MPI_Comm_free(&comm_);
    }
    Team(Team const&) = delete;
    Team& operator=(Team const&) = delete;
    bool contains_me() const { return static_cast<std::uint32_t>(world_rank()) < ranks_; }
    std::uint32_t ranks() const { return ranks_; }
    MPI_Comm comm() const { return comm_; }

private:
    std::uint32_t ranks_;
    MPI_Comm comm_ = MPI_COMM_NULL;
};

} // namespace scaling
