// Stands between the engine and MPI (the profiling interface, PMPI): counts messages and requests, delays calls at random, and yields.
#include "on_ranks.hpp"
#include <chrono>
#include <thread>

namespace {
mpi_test::Traffic traffic_so_far;
std::uint32_t most_delay_us = 0;
int requests = 0;

void wait_a_while()
{
    static engine_test::Random random{mpi_test::rank() + 1};
    if (most_delay_us != 0) std::this_thread::sleep_for(std::chrono::microseconds(random.below(most_delay_us)));
}
/// Gives its core away while it waits: tests have more ranks than cores, and an MPI library may not.
int wait_for(MPI_Request* request, MPI_Status* status)
{
    for (;;) {
        int done = 0;
        auto const error = PMPI_Test(request, &done, status);
        if (error != MPI_SUCCESS || done != 0) return error;
        std::this_thread::yield();
    }
}
} // namespace

namespace mpi_test {
void delay(std::uint32_t most_us)
{
    most_delay_us = most_us;
}
Traffic traffic()
{
    return std::exchange(traffic_so_far, {});
}
int requests_left()
{
    return requests;
}
} // namespace mpi_test

extern "C" {
int MPI_Isend(void const* buffer, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request)
{
    wait_a_while();
    ++requests;
    ++traffic_so_far.messages;
    traffic_so_far.words += static_cast<std::uint64_t>(n);
    return PMPI_Isend(buffer, n, type, to, tag, comm, request);
}
int MPI_Irecv(void* buffer, int n, MPI_Datatype type, int from, int tag, MPI_Comm comm, MPI_Request* request)
{
    wait_a_while();
    ++requests;
    return PMPI_Irecv(buffer, n, type, from, tag, comm, request);
}
int MPI_Iallreduce(void const* in, void* out, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm, MPI_Request* request)
{
    wait_a_while();
    ++requests;
    ++traffic_so_far.agreements;
    return PMPI_Iallreduce(in, out, n, type, op, comm, request);
}
int MPI_Allreduce(void const* in, void* out, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm)
{
    MPI_Request request;
    auto const error = PMPI_Iallreduce(in, out, n, type, op, comm, &request);
    return error != MPI_SUCCESS ? error : wait_for(&request, MPI_STATUS_IGNORE);
}
int MPI_Wait(MPI_Request* request, MPI_Status* status)
{
    wait_a_while();
    --requests;
    return wait_for(request, status);
}
}
