#pragma once
#include <cstdint>
#include <cstring>
#include <tilemesh/config.hpp>
#include <utility>

/// A few floats that are computed at once, with the compiler's vector extensions. A host lane and a tile share this source. `N` is 16, 8,
/// 4, 2 or 1; the compiler splits a vector that has more lanes than the target.
///
/// All of it is inlined into its caller, and its rounding rule with it: GCC gives an inlined body the options of the function that it is
/// inlined into. So call it only from functions that stand between TILEMESH_EXACT_BEGIN and TILEMESH_EXACT_END.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // the functions are always inlined, so it does not matter how a wide vector is passed
namespace tilemesh { inline namespace v0_2 { namespace splat::detail {

/// The number of floats that a core of this target computes at once: 16 with AVX-512, 8 with AVX, 2 on an IPU's worker, 4 elsewhere.
#if defined(__AVX512F__)
inline constexpr std::uint32_t native_lanes = 16;
#elif defined(__AVX__)
inline constexpr std::uint32_t native_lanes = 8;
#elif defined(__IPU__)
inline constexpr std::uint32_t native_lanes = 2;
#else
inline constexpr std::uint32_t native_lanes = 4;
#endif

template <class T, std::uint32_t N>
struct VectorOf {
    static_assert(N == 16 || N == 8 || N == 4 || N == 2 || N == 1, "lanes come in powers of two up to 16");
    typedef T type __attribute__((vector_size(N * sizeof(T))));
};
/// N floats. `+ - *` and compares work lane by lane; a compare gives a mask.
template <std::uint32_t N>
using Floats = typename VectorOf<float, N>::type;
/// N words. In a mask, all bits of a lane are set or none.
template <std::uint32_t N>
using Words = typename VectorOf<std::int32_t, N>::type;

template <std::uint32_t N>
using UnsignedWords = typename VectorOf<std::uint32_t, N>::type;

template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> broadcast(float v) noexcept
{
    return v - Floats<N>{}; // v - 0 is v in every bit; v + 0 would lose the sign of -0
}
template <std::uint32_t N>
TILEMESH_KERNEL Words<N> broadcast_word(std::int32_t v) noexcept
{
    return v - Words<N>{};
}
/// Loads N items from memory of any alignment.
template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> load(float const* p) noexcept
{
    Floats<N> v;
    std::memcpy(&v, p, sizeof v);
    return v;
}
template <std::uint32_t N>
TILEMESH_KERNEL Words<N> load_words(std::int32_t const* p) noexcept
{
    Words<N> v;
    std::memcpy(&v, p, sizeof v);
    return v;
}
template <class V, class T>
TILEMESH_KERNEL void store(T* p, V const& v) noexcept
{
    std::memcpy(p, &v, sizeof v);
}
template <std::uint32_t N>
TILEMESH_KERNEL Words<N> bits_of(Floats<N> const& v) noexcept
{
    return __builtin_bit_cast(Words<N>, v);
}
template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> floats_of(Words<N> const& v) noexcept
{
    return __builtin_bit_cast(Floats<N>, v);
}

#if defined(__clang__)
/// Written out lane by lane: Clang 16 sometimes keeps a loop over 16 lanes as a loop, and then none of it becomes a vector instruction.
template <std::uint32_t N, std::uint32_t... I>
TILEMESH_KERNEL Floats<N> fused_lanes(Floats<N> const& a, Floats<N> const& b, Floats<N> const& c,
                                      std::integer_sequence<std::uint32_t, I...>) noexcept
{
    return Floats<N>{__builtin_fmaf(a[I], b[I], c[I])...};
}
#endif
/// a * b + c lane by lane, rounded as by the scalar `multiply_add`.
template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> multiply_add_lanes(Floats<N> const& a, Floats<N> const& b, Floats<N> const& c) noexcept
{
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA) || defined(__IPU__)
#    if defined(__clang__)
    return fused_lanes<N>(a, b, c, std::make_integer_sequence<std::uint32_t, N>{});
#    else
    // GCC 12 leaves some loops over lanes scalar, so the instruction itself where there is one.
#        if defined(__AVX512F__)
    if constexpr (N == 16) return __builtin_ia32_vfmaddps512_mask(a, b, c, static_cast<unsigned short>(0xffff), 4); // 4: the current rounding
#        endif
#        if defined(__FMA__)
    if constexpr (N == 8) return __builtin_ia32_vfmaddps256(a, b, c);
    if constexpr (N == 4) return __builtin_ia32_vfmaddps(a, b, c);
#        endif
    Floats<N> r{}; // a loop: GCC 12 leaves some of the written-out form scalar
    for (std::uint32_t i = 0; i < N; ++i) r[i] = __builtin_fmaf(a[i], b[i], c[i]);
    return r;
#    endif
#else
    return a * b + c;
#endif
}

}}} // namespace tilemesh::splat::detail
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
