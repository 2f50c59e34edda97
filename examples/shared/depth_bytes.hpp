#pragma once
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

namespace shared {

/// Have the levels of a depth picture, row by row, their high byte in place of the low one? Level 0 is not known and does not count.
///
/// Where a surface passes a multiple of 256 levels, the high byte of a right depth changes by 1 and the low byte jumps. The answer is yes if
/// neighbours with other low bytes are often, in 1 of 16 pairs and in 16 pairs at least, less than 128 levels apart with their bytes swapped, and
/// further than 2^15 levels apart as they are. Right depths have no such pairs, and noise has 1 in 500. The answer is no for depths that say
/// nothing, as a constant one or one below 256 levels.
inline bool has_swapped_bytes(std::span<std::uint16_t const> levels, std::size_t width)
{
    auto const swapped = [](int level) { return (level & 255) << 8 | level >> 8; };
    std::size_t differ = 0, carry = 0;
    for (std::size_t i = 0; i < levels.size(); ++i)
        for (std::size_t const next : {i + 1, i + width}) {
            if (next >= levels.size() || (next == i + 1 && next % width == 0)) continue;
            int const a = levels[i], b = levels[next];
            if (a == 0 || b == 0 || (a & 255) == (b & 255)) continue;
            ++differ;
            if (std::abs(a - b) > 32768 && std::abs(swapped(a) - swapped(b)) < 128) ++carry;
        }
    return carry >= 16 && 16 * carry >= differ;
}

} // namespace shared
