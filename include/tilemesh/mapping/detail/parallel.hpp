#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <tilemesh/joined_threads.hpp>

namespace tilemesh { inline namespace v0_2 { namespace mapping::detail {

/// Calls f(i) once for each i below n, on `threads` threads, of which the caller's is one. f must not throw, and its calls must not
/// depend on each other. Throws std::system_error if the system gives fewer threads; then no call is missing that was begun.
template <class F>
void in_parallel(std::uint32_t threads, std::size_t n, F const& f)
{
    std::atomic<std::size_t> next{0};
    auto const work = [&]() noexcept {
        for (std::size_t i = next++; i < n; i = next++) f(i);
    };
    JoinedThreads helpers;
    for (std::uint32_t t = 1; t < threads && t < n; ++t) helpers.start(work);
    work();
}

}}} // namespace tilemesh::mapping::detail
