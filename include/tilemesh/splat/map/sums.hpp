#pragma once
#include <cmath>
#include <cstdint>
#include <tilemesh/splat/number.hpp>
#include <tilemesh/splat/projection.hpp>
#include <type_traits>

/// What a picture's loss tells each splat: ten sums over its pixels, in integers. So the sums have the same bits for any order of the
/// blocks.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // the functions are always inlined, so it does not matter how a wide vector is passed
namespace tilemesh { inline namespace v0_2 { namespace splat::map {

/// The ten sums of a splat. gP is the slope of the loss by the splat's power in a pixel, w its weight there. In the splat's own units,
/// with dx, dy from the mean: X = dx sqrt(-2 along), O = (dy - slope dx) sqrt(-2 across), so the power is -(X^2 + O^2) / 2.
enum Sum : std::uint32_t {
    gp,                 ///< sum of gP
    gp_x, gp_o,         ///< sums of gP X, gP O
    gp_xx, gp_xo, gp_oo,
    w_red, w_green, w_blue, ///< sums of w times the slope by the pixel's colour: the slope by the splat's colour
    w_depth             ///< sum of w times the slope by the pixel's depth sum: the slope by the splat's depth
};
inline constexpr std::uint32_t sums = 10;

/// A splat's sums in quanta (`quanta_per_unit`). The depth's sum is counted times the splat's depth. 40 bytes of a message.
struct SplatSums {
    std::int32_t of[sums];

    bool empty() const noexcept
    {
        std::int32_t any = 0;
        for (auto const v : of) any |= v;
        return any == 0;
    }
    SplatSums& operator+=(SplatSums const& other) noexcept
    {
        for (std::uint32_t k = 0; k < sums; ++k) of[k] += other.of[k];
        return *this;
    }
};
static_assert(sizeof(SplatSums) == 4 * sums && std::is_trivially_copyable_v<SplatSums>, "ten words");

/// A bound of the sums of alpha, alpha X^2, alpha O^2, alpha |X O|, alpha |X| and alpha |O| over any set of pixels of the splat.
///
/// A pixel adds at most `opacity` to each: X^2 e^(-X^2 / 2) <= 2 / e. So the pixels of the rectangle bound the sum. If the dilation is
/// 0.3 or more, the deviation is at least 0.547 pixels in any direction, and by Poisson's summation formula a sum over the pixel grid
/// exceeds the integral, 2 pi opacity / sqrt(4 along across), by less than 1.2 % (alpha), or 7 % (alpha X^2, alpha O^2). |X|, |O| and |X
/// O| follow by Cauchy's inequality.
inline float largest_sum(Splat const& s, float dilation) noexcept
{
    PixelRect const r = s.rect();
    float const by_pixels = s.opacity * static_cast<float>(r.x1 - r.x0) * static_cast<float>(r.y1 - r.y0);
    if (!(dilation >= 0.3f)) return by_pixels;
    float const by_area = 1.07f * 6.2831853f * s.opacity / (2.0f * std::sqrt(s.along * s.across));
    return by_area < by_pixels ? by_area : by_pixels;
}
/// The inverse of the quantum of a splat's sums, a power of two. Every copy of a splat computes it from the splat: no word travels with
/// it.
///
/// A pair is clipped to `limit` times its weight, which is at most alpha. So a sum is at most limit * largest_sum, which is at most 2^29
/// quanta. Each block is rounded once, by half a quantum: the 5.4e7 blocks of the largest frame add less than 2^25. Rounding of floats in
/// a block adds less than 1e-4 of the sum. So every sum of any blocks is below 2^30, and no int32 overflows (tests/splat/map_sums.cpp).
inline float quanta_per_unit(Splat const& s, float dilation, float limit) noexcept
{
    float const most = limit * largest_sum(s, dilation);
    return splat::detail::inverse_of_power(splat::detail::power_of_two_below(most > 0x1p-60f ? most : 0x1p-60f)) * 0x1p28f;
}
inline constexpr std::int32_t most_quanta = 1 << 30;

/// The sums as numbers: moments of gP in X and O, slopes by colours and depth.
template <class A>
struct Moments {
    typename A::Real of[sums];
};
inline Moments<splat::detail::OneFloat> moments_of(SplatSums const& s, Splat const& splat, float dilation, float limit) noexcept
{
    Moments<splat::detail::OneFloat> m;
    float const quantum = 1.0f / quanta_per_unit(splat, dilation, limit); // exact
    for (std::uint32_t k = 0; k < sums; ++k) m.of[k] = static_cast<float>(s.of[k]) * quantum;
    m.of[w_depth] = m.of[w_depth] / splat.depth();
    return m;
}

}}} // namespace tilemesh::splat::map
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
