#pragma once
#include <cmath>
#include <cstdint>
#include <tilemesh/splat/exponential.hpp>
#include <tilemesh/splat/lanes.hpp>
#include <utility>

/// The arithmetic in which code is written that runs for one float and for many lanes: a class `A` with the types `A::Real`, `A::Word`
/// (int32), `A::Mask` and the operations below. Code also uses `+ - * /`, compares and integer arithmetic. The same source gives the same
/// bits in a lane as for one float, because each operation is the correctly rounded one of IEEE 754 or an integer operation.
///
/// All of it is inlined into its caller. Call it only between TILEMESH_EXACT_BEGIN and TILEMESH_EXACT_END, as the functions of lanes.hpp.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // the functions are always inlined, so it does not matter how a wide vector is passed
namespace tilemesh { inline namespace v0_2 { namespace splat::detail {

template <class A>
struct Vector3 {
    typename A::Real x, y, z;
};

/// One float.
struct OneFloat {
    using Real = float;
    using Word = std::int32_t;
    using Mask = bool;
    static constexpr std::uint32_t lanes = 1;

    /// The same number in all lanes.
    TILEMESH_KERNEL static Real all(float v) noexcept { return v; }
    /// Set where all masks are set.
    template <class... Masks>
    TILEMESH_KERNEL static Mask every(Masks... m) noexcept
    {
        return (... && m);
    }
    TILEMESH_KERNEL static Mask negation(Mask m) noexcept { return !m; }
    TILEMESH_KERNEL static bool any(Mask m) noexcept { return m; }
    TILEMESH_KERNEL static Real select(Mask m, Real yes, Real no) noexcept { return m ? yes : no; }
    /// The word where the mask is set; 0 elsewhere.
    TILEMESH_KERNEL static Word keep(Mask m, Word v) noexcept { return m ? v : 0; }
    TILEMESH_KERNEL static Word bits(Real v) noexcept { return __builtin_bit_cast(Word, v); }
    TILEMESH_KERNEL static Real floats(Word v) noexcept { return __builtin_bit_cast(Real, v); }
    TILEMESH_KERNEL static Real magnitude(Real v) noexcept { return std::fabs(v); }
    /// The integer part of v. The result is undefined if an int32 cannot hold it.
    TILEMESH_KERNEL static Word truncate(Real v) noexcept { return static_cast<Word>(v); }
    TILEMESH_KERNEL static Real real(Word v) noexcept { return static_cast<Real>(v); }
    TILEMESH_KERNEL static Real multiply_add(Real a, Real b, Real c) noexcept { return tilemesh::multiply_add(a, b, c); }
    TILEMESH_KERNEL static Real square_root(Real v) noexcept { return std::sqrt(v); }
    TILEMESH_KERNEL static Real exponential(Real v) noexcept { return splat::exponential(v); }
};

/// `Count` lane numbers from `First` on.
template <int First, int... I>
constexpr std::integer_sequence<int, First + I...> count_from(std::integer_sequence<int, I...>) noexcept
{
    return {};
}
template <int First, int Count>
using Range = decltype(count_from<First>(std::make_integer_sequence<int, Count>{}));

/// Picks lanes by number. The lanes of `b` are numbered after those of `a`.
template <class V, class To, int... I>
TILEMESH_KERNEL void pick(V const& a, V const& b, To& to, std::integer_sequence<int, I...>) noexcept
{
    to = __builtin_shufflevector(a, b, I...);
}
template <class V, class Half>
TILEMESH_KERNEL void split(V const& v, Half& low, Half& high) noexcept
{
    constexpr int half = static_cast<int>(sizeof(Half) / 4);
    pick(v, v, low, Range<0, half>{});
    pick(v, v, high, Range<half, half>{});
}
template <class V, class Half>
TILEMESH_KERNEL void join(Half const& low, Half const& high, V& v) noexcept
{
    pick(low, high, v, Range<0, static_cast<int>(sizeof(V) / 4)>{});
}

/// `any_lane` without a loop: 1 if a lane of the mask is set, else 0.
template <std::uint32_t N>
TILEMESH_KERNEL std::uint32_t any_pixel(Words<N> const& mask) noexcept
{
#if defined(__AVX512F__) && defined(__AVX512DQ__)
    if constexpr (N == 16) return __builtin_ia32_cvtd2mask512(mask) != 0 ? 1u : 0u;
#endif
#if defined(__AVX__)
    if constexpr (N == 8) return __builtin_ia32_movmskps256(floats_of<8>(mask)) != 0 ? 1u : 0u;
#endif
#if defined(__SSE__)
    if constexpr (N == 4) return __builtin_ia32_movmskps(floats_of<4>(mask)) != 0 ? 1u : 0u;
#endif
    if constexpr (N > 4) {
        Words<N / 2> low, high;
        split(mask, low, high);
        return any_pixel<N / 2>(low | high);
    } else {
        return any_lane<N>(mask);
    }
}

/// N floats. More lanes than the target has are correct but slow.
template <std::uint32_t N>
struct FloatLanes {
    static_assert(N == 2 || N == 4 || N == 8 || N == 16, "2, 4, 8 or 16 lanes; one is OneFloat");
    using Real = Floats<N>;
    using Word = Words<N>;
    using Mask = Words<N>;
    static constexpr std::uint32_t lanes = N;

    TILEMESH_KERNEL static Real all(float v) noexcept { return detail::broadcast<N>(v); }
    template <class... Masks>
    TILEMESH_KERNEL static Mask every(Masks const&... m) noexcept
    {
        return (... & m);
    }
    TILEMESH_KERNEL static Mask negation(Mask const& m) noexcept { return ~m; }
    TILEMESH_KERNEL static bool any(Mask const& m) noexcept
    {
        if constexpr (N > 4) {
            Words<N / 2> low, high;
            split(m, low, high);
            return FloatLanes<N / 2>::any(low | high);
        } else if constexpr (N == 2) {
            return (m[0] | m[1]) != 0;
        } else {
            return (m[0] | m[1] | m[2] | m[3]) != 0;
        }
    }
    TILEMESH_KERNEL static Real select(Mask const& m, Real const& yes, Real const& no) noexcept { return m ? yes : no; }
    TILEMESH_KERNEL static Word keep(Mask const& m, Word const& v) noexcept { return m & v; }
    TILEMESH_KERNEL static Word bits(Real const& v) noexcept { return bits_of<N>(v); }
    TILEMESH_KERNEL static Real floats(Word const& v) noexcept { return floats_of<N>(v); }
    TILEMESH_KERNEL static Real magnitude(Real const& v) noexcept { return floats(bits(v) & 0x7fffffff); }
    TILEMESH_KERNEL static Word truncate(Real const& v) noexcept { return __builtin_convertvector(v, Word); }
    TILEMESH_KERNEL static Real real(Word const& v) noexcept { return __builtin_convertvector(v, Real); }
    TILEMESH_KERNEL static Real multiply_add(Real const& a, Real const& b, Real const& c) noexcept
    {
        return multiply_add_lanes<N>(a, b, c);
    }
    /// The square-root instruction itself. It rounds as std::sqrt does. std::sqrt may set errno, so a loop over lanes would stay N calls.
    TILEMESH_KERNEL static Real square_root(Real const& v) noexcept
    {
#if defined(__SSE2__)
#    if defined(__AVX__)
        if constexpr (N == 8) return __builtin_ia32_sqrtps256(v);
#    endif
        if constexpr (N == 4) {
            return __builtin_ia32_sqrtps(v);
        } else if constexpr (N == 2) {
            return Real{std::sqrt(v[0]), std::sqrt(v[1])};
        } else {
            Floats<N / 2> low, high;
            split(v, low, high);
            Real roots;
            join(FloatLanes<N / 2>::square_root(low), FloatLanes<N / 2>::square_root(high), roots);
            return roots;
        }
#else
        Real r;
        for (std::uint32_t i = 0; i < N; ++i) r[i] = std::sqrt(v[i]);
        return r;
#endif
    }
    TILEMESH_KERNEL static Real exponential(Real const& v) noexcept { return exponential_lanes<N>(v); }
};

}}} // namespace tilemesh::splat::detail
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
