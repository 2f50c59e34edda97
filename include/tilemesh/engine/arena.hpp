#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <sys/mman.h>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace engine {

/// Zeroed 32-bit words that take no memory until they are written: the capacity of a mesh is address space, and its live words are memory.
/// Throws std::bad_alloc if there is not enough address space.
class Arena {
public:
    Arena() = default;
    /// Throws std::bad_alloc if there is no memory; also if the bytes do not fit into a std::size_t (a host of 32 bits).
    explicit Arena(std::uint64_t words) : bytes_(static_cast<std::size_t>(words * 4))
    {
        if (words > std::numeric_limits<std::size_t>::max() / 4) throw std::bad_alloc{};
        if (bytes_ == 0) return;
        void* const p = ::mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
        if (p == MAP_FAILED) throw std::bad_alloc{};
        words_ = static_cast<std::uint32_t*>(p);
        // If the system uses huge pages by default, the first word of each list would take 2 MiB.
        (void)::madvise(p, bytes_, MADV_NOHUGEPAGE);
    }
    Arena(Arena&& other) noexcept : words_(std::exchange(other.words_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}
    Arena& operator=(Arena&& other) noexcept
    {
        std::swap(words_, other.words_);
        std::swap(bytes_, other.bytes_);
        return *this;
    }
    ~Arena()
    {
        if (words_ != nullptr) ::munmap(words_, bytes_);
    }
    std::uint32_t* data() const noexcept { return words_; }
    std::size_t words() const noexcept { return bytes_ / 4; }

private:
    std::uint32_t* words_ = nullptr;
    std::size_t bytes_ = 0;
};

}}} // namespace tilemesh::engine
