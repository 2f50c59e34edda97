#pragma once
#include <cstdint>

/// failing_allocation.cpp replaces operator new, but under TSan.
namespace mpi_test {

/// From now on allocation n of this thread fails, once; 0: none. The count begins anew.
void fail_allocation(std::uint64_t n) noexcept;
/// Whether operator new is replaced.
bool allocations_can_fail() noexcept;
/// The allocations of this thread since then.
std::uint64_t allocations() noexcept;
/// Ends this process after so many seconds: the others would otherwise wait for a rank that left them. 0: never.
void end_after(unsigned seconds) noexcept;

} // namespace mpi_test
