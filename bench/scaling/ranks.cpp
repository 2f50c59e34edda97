#include "ranks.hpp"
#include <chrono>
#include <common/statistics.hpp>
#include <thread>

namespace scaling {

Calls calls;

int world_rank()
{
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    return rank;
}
std::uint32_t world_size()
{
    int size = 0;
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    return static_cast<std::uint32_t>(size);
}
void meet()
{
    MPI_Request request;
    PMPI_Ibarrier(MPI_COMM_WORLD, &request);
    for (int done = 0; PMPI_Test(&request, &done, MPI_STATUS_IGNORE), done == 0;) std::this_thread::sleep_for(std::chrono::microseconds(200));
}
std::vector<std::uint32_t> numbers_of_ranks()
{
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t n = 1; n < world_size(); n *= 2) numbers.push_back(n);
    numbers.push_back(world_size());
    return numbers;
}
std::string spread(std::vector<double> const& samples)
{
    return bench::fixed(bench::median(samples), 2) + " (" + bench::fixed(bench::quantile(samples, 0.2), 2) + " to " +
           bench::fixed(bench::quantile(samples, 0.8), 2) + ")";
}

} // namespace scaling

extern "C" {
int MPI_Isend(void const* buffer, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request)
{
    int size = 0;
    PMPI_Type_size(type, &size);
    ++scaling::calls.messages;
    scaling::calls.bytes += double{1} * n * size;
    return PMPI_Isend(buffer, n, type, to, tag, comm, request);
}
int MPI_Iallreduce(void const* in, void* out, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm, MPI_Request* request)
{
    ++scaling::calls.agreements;
    return PMPI_Iallreduce(in, out, n, type, op, comm, request);
}
int MPI_Wait(MPI_Request* request, MPI_Status* status)
{
    bench::Stopwatch watch;
    auto const error = PMPI_Wait(request, status);
    scaling::calls.waiting_ms += watch.lap();
    return error;
}
}
