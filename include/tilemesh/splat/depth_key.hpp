#pragma once
#include <cstdint>
#include <tilemesh/splat/number.hpp>
#include <tilemesh/splat/view.hpp>

/// The depth of a splat as a word of 32 bits that rises with it: the key of the depth order.
///
/// The bits of a float32 have this order too, but waste it: a third of the wrongly ordered neighbours of a map have one float32, and a sum in
/// float32 is wrong by several last bits. This word is rounded once from a depth in two floats. It has 28 significant bits
/// where depths of maps are, in 16 binades from 2^-6 to 2^10 (16 mm to 1 km in a map in metres), and the 24 of a float32 elsewhere:
///
///     below 2^-6         the bits of the float32
///     2^-6 to 2^10       0x40000000 + the steps of 2^-27 binades above 2^-6
///     from 2^10 on       0xc0000000 + the bits of the float32 above those of 2^10
///
/// So all ones stays free. 0 stands for no depth.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // the functions are always inlined, so it does not matter how a wide vector is passed
namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace detail {
inline constexpr float fine_from = 0x1p-6f, fine_to = 0x1p10f;
inline constexpr std::int32_t bits_of_fine_from = 0x3c800000, bits_of_fine_to = 0x44800000;
inline constexpr std::uint32_t first_fine_key = 0x40000000u, first_far_key = 0xc0000000u;

/// What a rounded sum of a and b lacks, exactly (Knuth 1969).
template <class Real>
TILEMESH_KERNEL Real rest_of_sum(Real const& a, Real const& b, Real const& sum) noexcept
{
    Real const b_in_sum = sum - a;
    return (a - (sum - b_in_sum)) + (b - b_in_sum);
}

/// The key of depth + rest, where `depth` is their sum in float32.
template <class A>
TILEMESH_KERNEL typename A::Word key_of(typename A::Real const& depth, typename A::Real const& rest) noexcept
{
    using Word = typename A::Word;
    auto const is_fine = A::every(depth >= A::all(fine_from), depth < A::all(fine_to));
    Word const bits = A::bits(depth), fine_bits = A::bits(A::select(is_fine, depth, A::all(fine_from)));
    // The rest in sixteenths of the last bit of `depth`, -8 to 8.
    typename A::Real const scale = A::floats(0x7f000000 - (fine_bits & 0x7f800000));
    typename A::Real const sixteenths = A::select(is_fine, rest * scale * A::all(0x1p27f), A::all(0.0f)) + A::all(8.5f);
    Word const steps = ((fine_bits - bits_of_fine_from) << 4) + (A::truncate(sixteenths) - 8);
    Word const fine = (A::keep(steps > 0, steps) - 0x40000000) ^ static_cast<std::int32_t>(0x80000000u); // + 0x40000000, without a carry
    // The bits have 0x40000000 where this has a meaning. In this order nothing overflows, whatever they are elsewhere.
    Word const far = (bits | static_cast<std::int32_t>(first_far_key)) - (bits_of_fine_to - 0x40000000);
    return A::keep(is_fine, fine) | A::keep(depth >= A::all(fine_to), far) | A::keep(depth < A::all(fine_from), bits);
}

/// The keys of means that are visible, from their differences `d` to the camera, which are rounded. In other lanes they have no meaning.
///
/// The depth is a sum of two floats. A difference and its rest are exact. Of a product's factors, the 12 leading bits of each are multiplied
/// exactly. The other products are below 2^-11 of the whole, and so are their roundings below 2^-34.
template <class A>
TILEMESH_KERNEL typename A::Word depth_keys(Camera const& c, Vector3<A> const& mean, Vector3<A> const& d) noexcept
{
    using Real = typename A::Real;
    Real small = A::all(0.0f);
    auto const product = [&](Real const& m, Real const& difference, std::uint32_t k, Real& to) noexcept {
        constexpr std::int32_t leading = -0x1000; // sign, exponent and 12 bits of a significand
        float const w = c.rotation[2][k], w_leading = OneFloat::floats(OneFloat::bits(w) & leading);
        Real const d_leading = A::floats(A::bits(difference) & leading);
        Real const rest = rest_of_sum<Real>(m, A::all(-c.position[k]), difference);
        to = d_leading * w_leading;
        small = small + ((difference - d_leading) * w_leading + (difference * (w - w_leading) + rest * w));
    };
    Real x, y, z;
    product(mean.x, d.x, 0, x), product(mean.y, d.y, 1, y), product(mean.z, d.z, 2, z);
    Real const two = x + y, three = two + z;
    small = small + (rest_of_sum<Real>(x, y, two) + rest_of_sum<Real>(two, z, three));
    Real const depth = three + small;
    auto const behind = depth < A::all(c.near_depth); // the float32 that decided on the near plane was rounded more often
    return key_of<A>(A::select(behind, A::all(c.near_depth), depth), A::select(behind, A::all(0.0f), small - (depth - three)));
}
} // namespace detail

/// The key of depth + rest, where `depth` is their sum in float32.
inline std::uint32_t key_of_depth(float depth, float rest = 0) noexcept
{
    return static_cast<std::uint32_t>(detail::key_of<detail::OneFloat>(depth, rest));
}
/// The float32 that is nearest to the depth of a key.
inline float depth_of_key(std::uint32_t key) noexcept
{
    using namespace detail;
    if (key < first_fine_key) return __builtin_bit_cast(float, key);
    if (key < first_far_key) return __builtin_bit_cast(float, ((key - first_fine_key + 8) >> 4) + static_cast<std::uint32_t>(bits_of_fine_from));
    return __builtin_bit_cast(float, key - first_far_key + static_cast<std::uint32_t>(bits_of_fine_to));
}

}}} // namespace tilemesh::splat
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
