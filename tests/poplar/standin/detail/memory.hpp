#pragma once
#include "../poplar/exceptions.hpp"
#include "settings.hpp"
#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <sys/mman.h>
#include <unistd.h>
#include <vector>

#if defined(__SANITIZE_ADDRESS__)
#    define TILEMESH_STANDIN_ASAN 1
#elif defined(__has_feature)
#    if __has_feature(address_sanitizer)
#        define TILEMESH_STANDIN_ASAN 1
#    endif
#endif
#ifdef TILEMESH_STANDIN_ASAN
#    include <sanitizer/asan_interface.h>
#    define TILEMESH_STANDIN_UNCHECKED __attribute__((no_sanitize("address"), noinline))
#else
#    define TILEMESH_STANDIN_UNCHECKED
#endif

/// Tile memory on the host, and the stand-in's own access to it.
namespace standin::detail {

#ifdef TILEMESH_STANDIN_ASAN
inline constexpr bool has_asan = true;
inline void close_to_asan(void const* at, std::size_t bytes)
{
    __asan_poison_memory_region(at, bytes);
}
inline void open_to_asan(void const* at, std::size_t bytes)
{
    __asan_unpoison_memory_region(at, bytes);
}
#else
inline constexpr bool has_asan = false;
inline void close_to_asan(void const*, std::size_t) {}
inline void open_to_asan(void const*, std::size_t) {}
#endif

/// memcpy that also works on tile memory that is closed to AddressSanitizer.
TILEMESH_STANDIN_UNCHECKED inline void raw_copy(void* to, void const* from, std::size_t bytes)
{
#ifdef TILEMESH_STANDIN_ASAN
#    if defined(__x86_64__)
    asm volatile("rep movsb" : "+D"(to), "+S"(from), "+c"(bytes) : : "memory");
#    else
    for (std::size_t i = 0; i < bytes; ++i)
        static_cast<unsigned char volatile*>(to)[i] = static_cast<unsigned char const volatile*>(from)[i];
#    endif
#else
    std::memcpy(to, from, bytes);
#endif
}

/// Eight bytes at any address.
struct __attribute__((packed, may_alias)) EightBytes {
    std::uint64_t value;
};
TILEMESH_STANDIN_UNCHECKED inline std::uint64_t raw_load(void const* at)
{
    return static_cast<EightBytes const*>(at)->value;
}

/// Fills memory with poison, in whole words from `at` on.
inline void fill_poison(unsigned char* at, std::size_t bytes)
{
    static std::vector<std::uint32_t> const block(4096, poison_word);
    for (std::size_t done = 0; done < bytes;) {
        std::size_t const n = std::min(bytes - done, block.size() * sizeof poison_word);
        raw_copy(at + done, block.data(), n);
        done += n;
    }
}

/// A number that changes if the bytes change. An accidental change keeps the number with a probability of 2^-64.
inline std::uint64_t digest(unsigned char const* at, std::size_t bytes)
{
    std::uint64_t sum = bytes;
    auto const mix = [&sum](std::uint64_t word) {
        sum = (sum ^ word) * 0x9e3779b97f4a7c15u; // 2^64 / golden ratio, odd: a bijection of `sum` for each word
        sum ^= sum >> 29;
    };
    std::size_t i = 0;
    for (; i + 8 <= bytes; i += 8) mix(raw_load(at + i));
    unsigned char rest[8] = {};
    raw_copy(rest, at + i, bytes - i);
    std::uint64_t last;
    std::memcpy(&last, rest, 8);
    mix(last);
    return sum;
}

/// The byte at an offset of a red zone. Its words differ from their neighbours and from poison, so a copied red zone shows.
constexpr unsigned char canary(std::size_t offset) noexcept
{
    auto const mixed = static_cast<std::uint32_t>(offset) * 2654435761u; // 2^32 / golden ratio
    return static_cast<unsigned char>(mixed >> 24 ^ mixed >> 9 ^ 0x5a);
}

/// Bytes of the red zone on each side of a piece of tile memory.
inline constexpr std::size_t red_zone = 16;
/// The alignment of each piece in bytes. It is more than the 16 bytes of an IPU's widest load, and enough for minAlign in public codelets.
inline constexpr std::size_t piece_align = 32;
/// The offset in a tile's arena at which an edge of no elements points: between two red zones, before the first piece.
inline constexpr std::size_t empty_edge_at = 32;
inline constexpr std::size_t first_piece_at = 64;

constexpr std::size_t round_up(std::size_t n, std::size_t to) noexcept
{
    return (n + to - 1) / to * to;
}

/// The memory of all tiles: one range of addresses full of poison. A page takes host memory from its first write on.
class TileMemory {
public:
    TileMemory() = default;
    TileMemory(TileMemory const&) = delete;
    TileMemory& operator=(TileMemory const&) = delete;
    ~TileMemory()
    {
        if (base_ != nullptr) {
            open_to_asan(base_, bytes_);
            ::munmap(base_, bytes_);
        }
    }

    static std::size_t page() { return static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)); }

    void map(std::size_t bytes)
    {
        bytes_ = round_up(std::max<std::size_t>(bytes, 1), page());
        void* const base = ::mmap(nullptr, bytes_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
        if (base == MAP_FAILED) fail();
        base_ = static_cast<unsigned char*>(base);
        for (std::size_t at = 0; at < bytes_; at += pattern_bytes)
            if (::mmap(base_ + at, std::min(pattern_bytes, bytes_ - at), PROT_READ | PROT_WRITE,
                       MAP_PRIVATE | MAP_FIXED | MAP_NORESERVE, pattern(), 0) == MAP_FAILED)
                fail();
        close_to_asan(base_, bytes_);
    }

    /// Makes all memory poison again.
    void forget() { ::madvise(base_, bytes_, MADV_DONTNEED); }

    /// Opens or closes access to a range of whole pages.
    void protect(std::size_t offset, std::size_t bytes, bool open)
    {
        if (bytes != 0 && ::mprotect(base_ + offset, bytes, open ? PROT_READ | PROT_WRITE : PROT_NONE) != 0) fail();
    }
    void protect_all(bool open) { protect(0, bytes_, open); }

    unsigned char* at(std::size_t offset) const { return base_ + offset; }
    bool holds(void const* address) const
    {
        auto const a = reinterpret_cast<std::uintptr_t>(address), b = reinterpret_cast<std::uintptr_t>(base_);
        return a >= b && a - b < bytes_;
    }
    std::size_t offset(void const* address) const
    {
        return reinterpret_cast<std::uintptr_t>(address) - reinterpret_cast<std::uintptr_t>(base_);
    }

private:
    /// A file of poison. Every mapping shows it until a write. With 4 MiB per mapping, a whole chip has 230 mappings.
    static constexpr std::size_t pattern_bytes = std::size_t{4} << 20;
    static int pattern()
    {
        static int const file = [] {
            int const f = ::memfd_create("poison", MFD_CLOEXEC);
            std::vector<std::uint32_t> const words(pattern_bytes / sizeof poison_word, poison_word);
            if (f < 0 || ::write(f, words.data(), pattern_bytes) != static_cast<ssize_t>(pattern_bytes)) fail();
            return f;
        }();
        return file;
    }
    [[noreturn]] static void fail()
    {
        throw poplar::poplar_error("The stand-in has no memory for the tiles (" + std::string(std::strerror(errno)) +
                                   "); use fewer tiles or variables");
    }

    unsigned char* base_ = nullptr;
    std::size_t bytes_ = 0;
};

} // namespace standin::detail
