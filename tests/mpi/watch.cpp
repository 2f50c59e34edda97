// Stands between the engine and MPI (the profiling interface, PMPI): counts messages and requests, holds calls back at random, and yields.
#include "on_ranks.hpp"
#include <chrono>
#include <thread>

namespace {
using Clock = std::chrono::steady_clock;
mpi_test::Traffic traffic_so_far;
std::uint32_t most_delay_us = 0;
int requests = 0;

std::uint32_t below(std::uint32_t n)
{
    static engine_test::Random random{mpi_test::rank() + 1};
    return random.below(n);
}
Clock::time_point some_time_from_now()
{
    return Clock::now() + std::chrono::microseconds(below(most_delay_us));
}

/// A call that the engine has made and MPI has not seen yet, or whose end the engine does not see yet. The engine holds `promised`. Calls
/// begin and end in an order that has nothing to do with the order of the engine's calls. A buffer that the engine changes too early is
/// sent as it then is.
struct Held {
    MPI_Request promised = MPI_REQUEST_NULL;
    std::function<int(MPI_Request*)> begin; ///< empty: it has begun
    MPI_Request real = MPI_REQUEST_NULL;
    bool done = false;
    Clock::time_point due; ///< it does not begin, or end, before
};
std::vector<Held> held;

/// Begins and tests the calls that are due, from a random one on.
int look_at_held()
{
    auto const first = held.empty() ? 0u : below(static_cast<std::uint32_t>(held.size()));
    for (std::size_t i = 0; i < held.size(); ++i) {
        auto& h = held[(first + i) % held.size()];
        if (h.done || Clock::now() < h.due) continue;
        int error = MPI_SUCCESS, done = 0;
        if (h.begin) {
            error = std::exchange(h.begin, nullptr)(&h.real);
            h.due = some_time_from_now();
        } else {
            error = PMPI_Test(&h.real, &done, MPI_STATUS_IGNORE);
            h.done = done != 0;
        }
        if (error != MPI_SUCCESS) return error;
    }
    return MPI_SUCCESS;
}
/// Begins a call now, or holds it back.
template <class Begin>
int begin(Begin const& begin, MPI_Request* request)
{
    ++requests;
    if (most_delay_us == 0) return begin(request);
    auto const query = [](void*, MPI_Status*) { return MPI_SUCCESS; };
    auto const nothing = [](void*) { return MPI_SUCCESS; };
    auto const cancel = [](void*, int) { return MPI_SUCCESS; };
    auto const error = PMPI_Grequest_start(query, nothing, cancel, nullptr, request);
    held.push_back({*request, begin, MPI_REQUEST_NULL, false, some_time_from_now()});
    return error;
}
/// Gives its core away while it waits: tests have more ranks than cores, and an MPI library may not.
int wait_for(MPI_Request* request, MPI_Status* status)
{
    for (;;) {
        int done = 0;
        auto error = look_at_held();
        auto const mine = std::find_if(held.begin(), held.end(), [&](Held const& h) { return h.promised == *request; });
        if (mine != held.end() && mine->done) {
            PMPI_Grequest_complete(*request);
            held.erase(mine);
            return PMPI_Wait(request, status);
        }
        if (mine == held.end() && error == MPI_SUCCESS) error = PMPI_Test(request, &done, status);
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
    ++traffic_so_far.messages;
    traffic_so_far.words += static_cast<std::uint64_t>(n);
    return begin([=](MPI_Request* real) { return PMPI_Isend(buffer, n, type, to, tag, comm, real); }, request);
}
int MPI_Irecv(void* buffer, int n, MPI_Datatype type, int from, int tag, MPI_Comm comm, MPI_Request* request)
{
    return begin([=](MPI_Request* real) { return PMPI_Irecv(buffer, n, type, from, tag, comm, real); }, request);
}
int MPI_Iallreduce(void const* in, void* out, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm, MPI_Request* request)
{
    ++traffic_so_far.agreements;
    return begin([=](MPI_Request* real) { return PMPI_Iallreduce(in, out, n, type, op, comm, real); }, request);
}
int MPI_Allreduce(void const* in, void* out, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm)
{
    MPI_Request request;
    auto const error = PMPI_Iallreduce(in, out, n, type, op, comm, &request);
    return error != MPI_SUCCESS ? error : wait_for(&request, MPI_STATUS_IGNORE);
}
int MPI_Wait(MPI_Request* request, MPI_Status* status)
{
    --requests;
    return wait_for(request, status);
}
}
