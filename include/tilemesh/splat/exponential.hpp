#pragma once
#include <cstdint>
#include <tilemesh/splat/lanes.hpp>

TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace detail {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
/// The bounds within which e^x is a normal number.
inline constexpr float lowest_power = -87.0f, highest_power = 88.0f;
/// alpha may be cut at this value or above: in the recurrence (blending_cells.hpp), and for `lowest_power_for`.
inline constexpr float faintest_cut = 0x1p-13f;
/// `exponential`, lane by lane.
template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> exponential_lanes(Floats<N> const& v, float lowest = lowest_power) noexcept
{
    constexpr float log2_e = 1.44269504088896341f;
    constexpr float ln2_high = 0.693359375f, ln2_low = -2.12194440e-4f;
    constexpr float to_integer = 12582912.0f; // 1.5 * 2^23: adding it rounds to the nearest integer
    Floats<N> x = v > lowest ? v : broadcast<N>(lowest);
    x = x < highest_power ? x : broadcast<N>(highest_power);
    Floats<N> const shifted = multiply_add_lanes<N>(x, broadcast<N>(log2_e), broadcast<N>(to_integer));
    Floats<N> const n = shifted - to_integer;
    Floats<N> r = multiply_add_lanes<N>(n, broadcast<N>(-ln2_high), x);
    r = multiply_add_lanes<N>(n, broadcast<N>(-ln2_low), r);
    Floats<N> p = multiply_add_lanes<N>(broadcast<N>(1.9875691500e-4f), r, broadcast<N>(1.3981999507e-3f));
    p = multiply_add_lanes<N>(p, r, broadcast<N>(8.3334519073e-3f));
    p = multiply_add_lanes<N>(p, r, broadcast<N>(4.1665795894e-2f));
    p = multiply_add_lanes<N>(p, r, broadcast<N>(1.6666665459e-1f));
    p = multiply_add_lanes<N>(p, r, broadcast<N>(5.0000001201e-1f));
    Floats<N> const value = 1.0f + multiply_add_lanes<N>(p, r * r, r);
    // The low bits of `shifted` hold n. Adding n to the exponent multiplies by 2^n.
    return floats_of<N>(bits_of<N>(value) + (bits_of<N>(shifted) << 23));
}
#pragma GCC diagnostic pop
} // namespace detail

/// The power that stands for all lower ones if alpha is cut at alpha_min. Its e^x times an opacity is far below `detail::faintest_cut`, but it is a
/// normal number. With `detail::lowest_power`, opacities below 0.7 would give denormal numbers, and these cost some processors a hundred cycles.
inline float lowest_power_for(float alpha_min) noexcept
{
    return alpha_min >= detail::faintest_cut ? -60.0f : detail::lowest_power;
}

/// e^x for x in [-87, 88]. Beyond these bounds it returns the value at the bound. NaN gives the value at the lower bound, so a broken input
/// fades instead of spreading. The error is below 2 ulp (tests/splat), and the result at 0 is exactly 1. There is no branch and no library
/// call, so a host lane and a tile give the same bits.
///
/// Method: the Cody-Waite reduction x = n ln 2 + r with ln 2 in two parts, then a polynomial of degree 6 on |r| <= 0.35. The constants of
/// the polynomial and of the reduction are those of Cephes expf (Moshier).
/// A caller may raise the lower bound.
inline float exponential(float x, float lowest = detail::lowest_power) noexcept
{
    return detail::exponential_lanes<1>(detail::Floats<1>{x}, lowest)[0];
}

}}} // namespace tilemesh::splat
TILEMESH_EXACT_END
