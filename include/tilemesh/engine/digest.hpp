#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace tilemesh { inline namespace v0_2 { namespace engine {

/// Mixes one word into a digest (the finaliser of SplitMix64: Steele, Lea, Flood 2014).
inline std::uint64_t mix(std::uint64_t h, std::uint64_t word) noexcept
{
    h += word + 0x9e3779b97f4a7c15u;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
    return h ^ (h >> 31);
}
/// Mixes n words into a digest, without their number.
inline std::uint64_t mix_words_on(std::uint64_t h, std::uint32_t const* words, std::size_t n) noexcept
{
    for (std::size_t i = 0; i < n; ++i) {
        std::uint32_t w;
        std::memcpy(&w, words + i, 4);
        h = (h ^ w) * 0x100000001b3u; // FNV-1a, one word at a time
    }
    return h;
}
/// Mixes n words and their number into a digest.
inline std::uint64_t mix_words(std::uint64_t h, std::uint32_t const* words, std::size_t n) noexcept
{
    return mix(mix_words_on(h, words, n), n);
}

/// Has T a form with more words, which digests take? An item of a host may leave out words that follow from the broadcast T::WholeBy; its
/// member `whole(broadcast)` returns a T::Whole with all words.
template <class T>
inline constexpr bool has_whole_words = requires { typename T::WholeBy; };

}}} // namespace tilemesh::engine
