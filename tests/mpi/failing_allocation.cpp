#include "failing_allocation.hpp"
#include "../standard.hpp"
#include <new>
#include <unistd.h>

// TSan's runtime has an operator new of its own that cannot be replaced: there no allocation fails.
#ifdef __SANITIZE_THREAD__
#define TILEMESH_TSAN
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define TILEMESH_TSAN
#endif
#endif

namespace {
thread_local std::uint64_t counted = 0, failing = 0;

#ifndef TILEMESH_TSAN
void* allocate(std::size_t bytes, std::size_t alignment) noexcept
{
    if (++counted == failing) return nullptr;
    bytes = (bytes + alignment - 1) / alignment * alignment;
    return std::aligned_alloc(alignment, bytes == 0 ? alignment : bytes);
}
void* allocate_or_throw(std::size_t bytes, std::size_t alignment)
{
    if (void* const p = allocate(bytes, alignment)) return p;
    throw std::bad_alloc();
}
constexpr std::size_t usual = alignof(std::max_align_t);
#endif
} // namespace

#ifndef TILEMESH_TSAN
void* operator new(std::size_t n) { return allocate_or_throw(n, usual); }
void* operator new[](std::size_t n) { return allocate_or_throw(n, usual); }
void* operator new(std::size_t n, std::nothrow_t const&) noexcept { return allocate(n, usual); }
void* operator new[](std::size_t n, std::nothrow_t const&) noexcept { return allocate(n, usual); }
void* operator new(std::size_t n, std::align_val_t a) { return allocate_or_throw(n, static_cast<std::size_t>(a)); }
void* operator new[](std::size_t n, std::align_val_t a) { return allocate_or_throw(n, static_cast<std::size_t>(a)); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, std::nothrow_t const&) noexcept { std::free(p); }
void operator delete[](void* p, std::nothrow_t const&) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete[](void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }
#endif

namespace mpi_test {
void fail_allocation(std::uint64_t n) noexcept
{
    counted = 0;
    failing = n;
}
bool allocations_can_fail() noexcept
{
#ifdef TILEMESH_TSAN
    return false;
#else
    return true;
#endif
}
std::uint64_t allocations() noexcept
{
    return counted;
}
void end_after(unsigned seconds) noexcept
{
    ::alarm(seconds);
}
} // namespace mpi_test
