#pragma once
#include <cstdint>
#include <cstring>
#include <tilemesh/splat/number.hpp>

/// Searches in lists of items of one or two 32-bit words. A tile looks for a record in all its marks, so these loops take a large part of
/// routing and bloom. They test 16 items at once, with the compiler's vectors: GCC 12 makes no vectors of a loop that ends early.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat {

inline constexpr std::uint32_t no_slot = 0xffffffffu;

namespace detail {
inline constexpr std::uint32_t searched_at_once = 16;

/// Is `test` true for word `Word` of one of 16 items? `test` takes words, and gives words that are not 0 where it is true.
template <std::uint32_t Word, class Item, class Test>
TILEMESH_KERNEL bool any_at_once(Item const* items, Test const& test) noexcept
{
    constexpr std::uint32_t words = sizeof(Item) / 4;
    static_assert(sizeof(Item) == 4 * words && (words == 1 || words == 2) && Word < words, "an item is one or two words");
    if constexpr (native_lanes >= 4) {
        Words<native_lanes> hits{};
        for (std::uint32_t at = 0; at < searched_at_once * words; at += native_lanes) {
            Words<native_lanes> v;
            std::memcpy(&v, reinterpret_cast<unsigned char const*>(items) + 4 * at, sizeof v);
            hits |= test(v);
        }
        if constexpr (words == 2) hits &= (counted_lanes<native_lanes>() & 1) == static_cast<std::int32_t>(Word);
        return FloatLanes<native_lanes>::any(hits);
    } else { // an IPU's worker computes one word at a time
        Words<1> hits{};
        for (std::uint32_t i = 0; i < searched_at_once; ++i) {
            Words<1> v;
            std::memcpy(&v, reinterpret_cast<unsigned char const*>(items + i) + 4 * Word, sizeof v);
            hits |= test(v);
        }
        return hits[0] != 0;
    }
}
template <std::uint32_t Word, class Item>
TILEMESH_KERNEL std::uint32_t word_of(Item const& item) noexcept
{
    std::uint32_t v;
    std::memcpy(&v, reinterpret_cast<unsigned char const*>(&item) + 4 * Word, sizeof v);
    return v;
}
} // namespace detail

/// The number of the first of n items whose first word is `word`, or `no_slot`.
template <class Item>
std::uint32_t first_with_word(Item const* items, std::uint32_t n, std::uint32_t word) noexcept
{
    auto const wanted = static_cast<std::int32_t>(word);
    std::uint32_t i = 0;
    while (i + detail::searched_at_once <= n && !detail::any_at_once<0>(items + i, [wanted](auto const& v) noexcept { return v == wanted; }))
        i += detail::searched_at_once;
    for (; i < n; ++i)
        if (detail::word_of<0>(items[i]) == word) return i;
    return no_slot;
}
/// Has one of 16 items one of these bits in its second word?
template <class Item>
TILEMESH_KERNEL bool has_bits_at_once(Item const* items, std::uint32_t bits) noexcept
{
    auto const wanted = static_cast<std::int32_t>(bits);
    return detail::any_at_once<1>(items, [wanted](auto const& v) noexcept { return v & wanted; });
}
/// The fewest numbers for which the two functions below need room.
inline constexpr std::uint32_t fewest_listed = detail::searched_at_once;

/// Lists the numbers of the items [begin, n) that have one of these bits in their second word, in ascending order, as far as there is room
/// for `most` numbers. Returns how many it listed, and sets `begin` to the item where the next call goes on; n if there is none.
template <class Item>
std::uint32_t list_up_with_bits(Item const* items, std::uint32_t& begin, std::uint32_t n, std::uint32_t bits, std::uint32_t* numbers,
                                std::uint32_t most) noexcept
{
    constexpr std::uint32_t step = detail::searched_at_once;
    std::uint32_t listed = 0;
    while (begin < n && most - listed >= step) {
        std::uint32_t const end = n - begin < step ? n : begin + step;
        if (end - begin == step && !has_bits_at_once(items + begin, bits)) {
            begin = end;
            continue;
        }
        for (; begin < end; ++begin) { // without a branch that depends on an item
            numbers[listed] = begin;
            listed += (detail::word_of<1>(items[begin]) & bits) != 0 ? 1 : 0;
        }
    }
    return listed;
}
/// As `list_up_with_bits`, for the items [0, end), in descending order. Sets `end` so that the next call goes on there; 0 if no item is left.
template <class Item>
std::uint32_t list_down_with_bits(Item const* items, std::uint32_t& end, std::uint32_t bits, std::uint32_t* numbers,
                                  std::uint32_t most) noexcept
{
    constexpr std::uint32_t step = detail::searched_at_once;
    std::uint32_t listed = 0;
    while (end != 0 && most - listed >= step) {
        std::uint32_t const begin = end < step ? 0 : end - step;
        if (end - begin == step && !has_bits_at_once(items + begin, bits)) {
            end = begin;
            continue;
        }
        while (end > begin) {
            numbers[listed] = --end;
            listed += (detail::word_of<1>(items[end]) & bits) != 0 ? 1 : 0;
        }
    }
    return listed;
}

}}} // namespace tilemesh::splat
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
