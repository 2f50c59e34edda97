#pragma once
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <tilemesh/splat/number.hpp>

TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see number.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace detail {
/// `logarithm` of one float, or of each lane.
template <class A>
TILEMESH_KERNEL typename A::Real logarithm(typename A::Real const& x) noexcept
{
    using Real = typename A::Real;
    using Word = typename A::Word;
    constexpr std::int32_t root_half = 0x3f3504f3, fraction = (1 << 23) - 1; // the bits of sqrt(1/2)
    constexpr float smallest = std::numeric_limits<float>::min(), infinity = std::numeric_limits<float>::infinity();
    Real const one = A::all(1.0f), least = A::all(smallest);

    // x = 2^e m with m from sqrt(1/2) to sqrt(2), so that nothing cancels near x = 1. The difference m - 1 is exact.
    Word const from_root = A::bits(A::select(x >= least, x, one)) - root_half;
    Real const e = A::real(from_root >> 23);
    Real const f = A::floats((from_root & fraction) + root_half) - one;
    Real const ff = f * f;
    Real p = A::all(7.0376836292e-2f);
    for (float const term : {-1.1514610310e-1f, 1.1676998740e-1f, -1.2420140846e-1f, 1.4249322787e-1f, -1.6668057665e-1f,
                             2.0000714765e-1f, -2.4999993993e-1f, 3.3333331174e-1f})
        p = A::multiply_add(p, f, A::all(term));
    Real rest = A::multiply_add(e, A::all(-2.12194440e-4f), p * f * ff);
    rest = A::multiply_add(A::all(-0.5f), ff, rest);
    Real const value = A::multiply_add(e, A::all(0.693359375f), f + rest);
    Real const none = A::all(std::numeric_limits<float>::quiet_NaN());
    return A::select(x >= least, A::select(x < A::all(infinity), value, x), none);
}
} // namespace detail

/// The natural logarithm of x in [2^-126, infinity]. A smaller x and NaN give NaN. The error is below 1 ulp (tests/splat), and the result
/// at 1 is exactly 0. There is no branch and no library call, so a host lane and a tile give the same bits.
///
/// Sources: the polynomial of degree 8 for m in [sqrt(1/2), sqrt(2)) and ln 2 in two parts are those of Cephes logf (Moshier).
inline float logarithm(float x) noexcept
{
    return detail::logarithm<detail::OneFloat>(x);
}

}}} // namespace tilemesh::splat
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
