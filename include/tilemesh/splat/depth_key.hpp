#pragma once
#include <cstdint>
#include <tilemesh/splat/number.hpp>
#include <tilemesh/splat/view.hpp>

/// The depth of a splat as a word of 32 bits that rises with it: the key of the depth order.
///
/// The bits of a float32 have this order too, but waste it: a third of the wrongly ordered neighbours of a map have one float32, and a sum in
/// float32 is wrong by several last bits. This word is rounded once, to the nearest, from a depth in double. It has 28 significant bits where
/// depths of maps are, in 16 binades from 2^-6 to 2^10 (16 mm to 1 km in a map in metres), and the 24 of a float32 elsewhere:
///
///     below 2^-6           the bits of the float32                             0 to first
///     2^-6 to 2^10         first + the steps of 2^-27 binades above 2^-6       first to last = first + 2^31
///     above 2^10           last + the bits of the float32 above those of 2^10
///
/// That is 0xf7800000 at infinity, so all ones stays free. 0 stands for no depth.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // the functions are always inlined, so it does not matter how a wide vector is passed
namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace detail {
inline constexpr float fine_from = 0x1p-6f, fine_to = 0x1p10f;
inline constexpr std::uint32_t first_fine_key = 0x3c800000u, last_fine_key = first_fine_key + (16u << 27); // the bits of fine_from
inline constexpr std::uint32_t coarse_to_key = last_fine_key - 0x44800000u;                                // the bits of fine_to
inline constexpr std::uint64_t fine_steps = std::uint64_t{1023 - 6} << 27; ///< fine_from in steps: the exponent of its double
inline constexpr std::uint32_t fine_shift = 52 - 27;

/// What the depths of one view share.
struct DepthAxis {
    double axis[3], position[3], near_depth;
    TILEMESH_KERNEL explicit DepthAxis(Camera const& c) noexcept
        : axis{double{c.rotation[2][0]}, double{c.rotation[2][1]}, double{c.rotation[2][2]}},
          position{double{c.position[0]}, double{c.position[1]}, double{c.position[2]}}, near_depth(double{c.near_depth})
    {
    }
};
/// The depth of a mean that is in front of the near plane by its float32. The differences and the products are exact, or wrong by 2^-53.
template <class Double>
TILEMESH_KERNEL Double depth_along(DepthAxis const& a, Double const& x, Double const& y, Double const& z) noexcept
{
    Double const sum = (x - a.position[0]) * a.axis[0] + (y - a.position[1]) * a.axis[1] + (z - a.position[2]) * a.axis[2];
    return sum < a.near_depth ? Double{} + a.near_depth : sum;
}

TILEMESH_KERNEL std::uint32_t key_of_depth(double z) noexcept
{
    auto const f = static_cast<float>(z);
    auto const bits = __builtin_bit_cast(std::uint32_t, f);
    if (f < fine_from) return bits;
    if (f >= fine_to) return bits + coarse_to_key;
    double const from = z < double{fine_from} ? double{fine_from} : z;
    auto const steps = (__builtin_bit_cast(std::uint64_t, from) + (std::uint64_t{1} << (fine_shift - 1))) >> fine_shift;
    return static_cast<std::uint32_t>(steps - fine_steps) + first_fine_key;
}

/// The depths in float32 and the fine keys of some lanes.
template <std::uint32_t N>
struct DepthLanes {
    Floats<N> depth;
    UnsignedWords<N> fine;
};
template <std::uint32_t N>
TILEMESH_KERNEL void depth_lanes(DepthAxis const& a, Floats<N> const& x, Floats<N> const& y, Floats<N> const& z, DepthLanes<N>& to) noexcept
{
    using Doubles = typename VectorOf<double, N>::type;
    using Bits = typename VectorOf<std::uint64_t, N>::type;
    Doubles const depth =
        depth_along<Doubles>(a, __builtin_convertvector(x, Doubles), __builtin_convertvector(y, Doubles), __builtin_convertvector(z, Doubles));
    Doubles const from = depth < double{fine_from} ? Doubles{} + double{fine_from} : depth;
    Bits const steps = (__builtin_bit_cast(Bits, from) + (std::uint64_t{1} << (fine_shift - 1))) >> fine_shift;
    using Depths = Floats<N>;
    using Keys = UnsignedWords<N>;
    to.depth = __builtin_convertvector(depth, Depths);
    to.fine = __builtin_convertvector(Bits(steps - fine_steps), Keys) + first_fine_key;
}

/// The keys of means that are visible, in an arithmetic of number.hpp. In other lanes they have no meaning.
TILEMESH_KERNEL std::int32_t depth_keys(OneFloat, Camera const& c, float x, float y, float z) noexcept
{
    return static_cast<std::int32_t>(key_of_depth(depth_along<double>(DepthAxis(c), double{x}, double{y}, double{z})));
}
template <std::uint32_t N>
TILEMESH_KERNEL Words<N> depth_keys(FloatLanes<N>, Camera const& c, Floats<N> const& x, Floats<N> const& y, Floats<N> const& z) noexcept
{
    DepthAxis const axis(c);
    Floats<N> depth;
    UnsignedWords<N> fine;
    if constexpr (N == 2) {
        DepthLanes<N> all;
        depth_lanes<N>(axis, x, y, z, all);
        depth = all.depth, fine = all.fine;
    } else { // halves, whose doubles fill a vector
        Floats<N / 2> xs[2], ys[2], zs[2];
        split(x, xs[0], xs[1]), split(y, ys[0], ys[1]), split(z, zs[0], zs[1]);
        DepthLanes<N / 2> low, high;
        depth_lanes<N / 2>(axis, xs[0], ys[0], zs[0], low);
        depth_lanes<N / 2>(axis, xs[1], ys[1], zs[1], high);
        join(low.depth, high.depth, depth), join(low.fine, high.fine, fine);
    }
    Words<N> const bits = bits_of<N>(depth), far = bits + static_cast<std::int32_t>(coarse_to_key);
    Words<N> const near_or_fine = depth < fine_from ? bits : __builtin_bit_cast(Words<N>, fine);
    return depth >= fine_to ? far : near_or_fine;
}
} // namespace detail

/// The float32 that is nearest to the depth of a key.
inline float depth_of_key(std::uint32_t key) noexcept
{
    using namespace detail;
    if (key - first_fine_key <= last_fine_key - first_fine_key)
        return static_cast<float>(__builtin_bit_cast(double, (key - first_fine_key + fine_steps) << fine_shift));
    return __builtin_bit_cast(float, key < first_fine_key ? key : key - coarse_to_key);
}

}}} // namespace tilemesh::splat
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
