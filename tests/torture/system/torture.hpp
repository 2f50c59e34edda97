#pragma once
#include <atomic>
#include <cstdint>

namespace torture {

/// Calls that fail together.
enum class Kind : std::uint32_t { memory, open, write, rename, fsync, mkdir, thread };
inline constexpr char const* names[] = {"memory", "open", "write", "rename", "fsync", "mkdir", "thread"};

/// Memory that the driver and the tested process share, at the start of a file in memory.
struct Page {
    Kind kind = Kind::memory;
    std::uint32_t alone = 1;             ///< 1: the call `first` fails; 0: all after it, too
    std::uint64_t first = 0;             ///< counted from 1; 0: none
    std::atomic<std::uint64_t> calls{0}; ///< of this kind, up to now
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free, "two processes share it");

} // namespace torture
