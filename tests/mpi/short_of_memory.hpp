#pragma once
#include "failing_allocation.hpp"
#include "on_ranks.hpp"
#include <exception>
#include <new>
#include <tilemesh/mpi/detail/ranks.hpp>

/// One rank runs out of memory, at each allocation of the library in turn.
namespace mpi_test {

/// Runs `act(fresh())` on all ranks, while one rank's allocation n fails, for all n (or 24 of them, over more than 3 ranks 4;
/// TILEMESH_TORTURE=all: all) and for the first and the last rank. Either all ranks then throw, or none. `after` tries again with what
/// `fresh` made, and must not throw.
template <class Fresh, class Act, class After>
void each_allocation_fails(Fresh const& fresh, Act const& act, After const& after)
{
    if (!allocations_can_fail()) {
        MESSAGE("skipped: no allocation can fail under TSan");
        return;
    }
    mpi::detail::Ranks const all(MPI_COMM_WORLD);
    char const* const wanted = std::getenv("TILEMESH_TORTURE");
    bool const every = wanted != nullptr && std::string(wanted) == "all";
    for (std::uint32_t const victim : {0u, ranks() - 1}) {
        CAPTURE(victim);
        std::uint64_t most = 0;
        for (std::uint64_t n = 0, step = 1; n <= most; n += step) { // n = 0 counts
            CAPTURE(n);
            auto object = fresh();
            std::string error;
            end_after(120);
            fail_allocation(rank() == victim ? n : 0);
            try {
                act(*object);
            } catch (std::bad_alloc const&) {
                fail_allocation(0);
                error = "out of memory here";
            } catch (std::exception const& e) {
                fail_allocation(0);
                error = e.what();
            }
            std::uint64_t words[] = {error.empty() ? 0u : 1u, rank() == victim && n == 0 ? allocations() : 0};
            fail_allocation(0);
            all.sum(words, 2);
            CHECK((words[0] == 0 || words[0] == ranks()));
            if (words[0] != 0) CHECK(has(error, "out of memory"));
            if (n == 0) {
                REQUIRE(error.empty());
                most = words[1];
                CHECK(most > 0);
                if (!every) step = most / (ranks() > 3 ? 4 : 24) + 1; // more ranks than cores take long
            }
            after(*object, !error.empty());
            end_after(0);
        }
        if (ranks() == 1) return;
    }
}

} // namespace mpi_test
