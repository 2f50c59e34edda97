#pragma once
#include <cstddef>
#include <cstdint>
#include <tilemesh/config.hpp>
#include <vector>
#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace tilemesh { inline namespace v0_2 { namespace report::detail {

/// `v.resize(n)` for an empty vector. Where the items are many, it asks the system for huge pages first, so that they do not wait for thousands of
/// page faults. A system that has none, or a vector below 4 MiB, is as before.
template <class T>
void resize_large(std::vector<T>& v, std::size_t n)
{
    v.reserve(n);
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    constexpr std::uintptr_t page = 4096, least = std::uintptr_t{4} << 20;
    auto const begin = (reinterpret_cast<std::uintptr_t>(v.data()) + page - 1) / page * page;
    auto const end = reinterpret_cast<std::uintptr_t>(v.data() + v.capacity()) / page * page;
    if (begin + least <= end) (void)::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
#endif
    v.resize(n);
}

}}} // namespace tilemesh::v0_2::report::detail
