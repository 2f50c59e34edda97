#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>

TILEMESH_EXACT_BEGIN
namespace tilemesh::splat {

/// e^x for x in [-87, 88], beyond that the value at the bound; NaN gives the lower bound, so that a broken input fades instead
/// of spreading. Error below 2 ulp (tests/splat), exactly 1 at 0, no branch, no library call: the same bits on a host lane
/// and on a tile.
///
/// Cody-Waite reduction x = n ln 2 + r with ln 2 in two parts, then a polynomial of degree 6 on |r| <= 0.35; the polynomial's
/// and the reduction's constants are those of Cephes expf (Moshier).
inline float exponential(float x) noexcept
{
    constexpr float lowest = -87.0f, highest = 88.0f; // e^x stays a normal number
    constexpr float log2_e = 1.44269504088896341f;
    constexpr float ln2_high = 0.693359375f, ln2_low = -2.12194440e-4f;
    constexpr float to_integer = 12582912.0f; // 1.5 * 2^23: adding it rounds to the nearest integer
    x = x > lowest ? x : lowest;
    x = x < highest ? x : highest;
    float const shifted = multiply_add(x, log2_e, to_integer);
    float const n = shifted - to_integer;
    float r = multiply_add(n, -ln2_high, x);
    r = multiply_add(n, -ln2_low, r);
    float p = 1.9875691500e-4f;
    p = multiply_add(p, r, 1.3981999507e-3f);
    p = multiply_add(p, r, 8.3334519073e-3f);
    p = multiply_add(p, r, 4.1665795894e-2f);
    p = multiply_add(p, r, 1.6666665459e-1f);
    p = multiply_add(p, r, 5.0000001201e-1f);
    float const value = 1.0f + multiply_add(p, r * r, r);
    // n sits in the low bits of `shifted`; adding it to the exponent multiplies by 2^n.
    return __builtin_bit_cast(float, __builtin_bit_cast(std::uint32_t, value) +
                                         (__builtin_bit_cast(std::uint32_t, shifted) << 23));
}

} // namespace tilemesh::splat
TILEMESH_EXACT_END
