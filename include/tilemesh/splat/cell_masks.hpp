#pragma once
#include <tilemesh/splat/cell_state.hpp>

/// Lists of the splats of cells for a host with AVX-512. No tile has such instructions, so words of 64 bits may be used here.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::detail {

template <std::uint32_t L>
TILEMESH_KERNEL Words<L> loaded(std::uint32_t const* p) noexcept
{
    Words<L> v;
    std::memcpy(&v, p, sizeof v);
    return v;
}

#if defined(__AVX512F__) && defined(__AVX512DQ__)
struct ByteNumbers { // 0, 1, 2 and so on
    alignas(64) char of[64]{};
    constexpr ByteNumbers() noexcept
    {
        for (int i = 0; i < 64; ++i) of[i] = static_cast<char>(i);
    }
};
inline constexpr ByteNumbers byte_numbers{};

/// `SwappedLists` (cell_lists.hpp) for a target with masks of 16 lanes. A cell's splats are bits, and the numbers of those that are set are stored.
template <std::uint32_t Size>
class MaskedLists {
    static_assert(Size % 64 == 0 && Size <= 128, "words of 64 bits, and numbers in signed bytes");
public:
    using Number = std::uint8_t;
    void begin(CellChunk<Size> const& chunk, std::uint32_t n, std::uint32_t cells) noexcept
    {
        std::uint32_t const words = (n + 63) / 64;
        for (std::uint32_t k = 0; k < words; ++k)
            for (std::uint32_t i = 0; i < cells; ++i) masks_[i][k] = bits_in(chunk.cells + 64 * k, 1u << i);
        for (std::uint32_t k = words; k < Size / 64; ++k)
            for (std::uint32_t i = 0; i < cells; ++i) masks_[i][k] = 0;
        if (n % 64 != 0)
            for (std::uint32_t i = 0; i < cells; ++i) masks_[i][n / 64] &= (std::uint64_t{1} << n % 64) - 1;
    }
    std::uint32_t count(std::uint32_t cell, std::uint32_t other) const noexcept
    {
        std::uint32_t n = 0;
        for (std::uint32_t k = 0; k < Size / 64; ++k) n += bits_set(masks_[cell][k] | masks_[other][k]);
        return n;
    }
    std::uint32_t list(std::uint32_t cell, std::uint32_t other, Number* to) const noexcept
    {
        std::uint32_t n = 0;
        for (std::uint32_t k = 0; k < Size / 64; ++k)
            if (std::uint64_t const splats = masks_[cell][k] | masks_[other][k]; splats != 0) n += list_bits(splats, 64 * k, to + n);
        to[n] = to[n + 1] = 0;
        return n;
    }

private:
    static std::uint32_t bits_set(std::uint64_t bits) noexcept { return static_cast<std::uint32_t>(__builtin_popcountll(bits)); }
    /// The words of 64 that have a bit of `bit`, as bits.
    static std::uint64_t bits_in(std::uint32_t const* words, std::uint32_t bit) noexcept
    {
        std::uint64_t all = 0;
        for (std::uint32_t i = 0; i < 4; ++i) {
            Words<16> const v = loaded<16>(words + 16 * i) & broadcast_word<16>(static_cast<std::int32_t>(bit));
#    if defined(__clang__)
            auto const lanes = __builtin_ia32_cvtd2mask512(v != 0);
#    else
            auto const lanes = __builtin_ia32_ptestmd512(v, v, static_cast<unsigned short>(0xffff));
#    endif
            all |= std::uint64_t{lanes} << 16 * i;
        }
        return all;
    }
    /// Stores first + i for each bit i that is set. Returns how many they are; it may write 64 bytes.
    static std::uint32_t list_bits(std::uint64_t bits, std::uint32_t first, Number* to) noexcept
    {
#    if defined(__AVX512VBMI2__)
        typedef char Bytes __attribute__((vector_size(64)));
        Bytes numbers;
        std::memcpy(&numbers, byte_numbers.of, sizeof numbers);
        store(to, __builtin_ia32_compressqi512_mask(numbers + static_cast<char>(first), Bytes{}, bits));
        return bits_set(bits);
#    else
        typedef char Bytes __attribute__((vector_size(16)));
        std::uint32_t n = 0;
        for (std::uint32_t i = 0; i < 64; i += 16) {
            auto const lanes = static_cast<unsigned short>(bits >> i);
            Words<16> const numbers = counted_lanes<16>() + static_cast<std::int32_t>(first + i);
            Words<16> const kept = __builtin_ia32_compresssi512_mask(numbers, Words<16>{}, lanes);
            store(to + n, __builtin_ia32_pmovdb512_mask(kept, Bytes{}, static_cast<unsigned short>(0xffff)));
            n += bits_set(lanes);
        }
        return n;
#    endif
    }

    std::uint64_t masks_[32][Size / 64];
};
#endif

}}} // namespace tilemesh::splat::detail
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
