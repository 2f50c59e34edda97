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
/// The most that a core may compute at once in this program: its hot functions may have wider vectors (instruction_sets.hpp).
inline constexpr std::uint32_t most_native_lanes = TILEMESH_INSTRUCTION_SETS ? 16 : native_lanes;

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
/// 0, 1, 2 and so on.
template <std::uint32_t N>
TILEMESH_KERNEL Words<N> counted_lanes() noexcept
{
    constexpr std::int32_t numbers[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    Words<N> v;
    std::memcpy(&v, numbers, sizeof v);
    return v;
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

/// 1 if any lane of a mask is set, else 0.
template <std::uint32_t N>
TILEMESH_KERNEL std::uint32_t any_lane(Words<N> const& mask) noexcept
{
#if defined(__wasm_simd128__)
    typedef signed char Bytes __attribute__((vector_size(16)));
    if constexpr (N == 4) return static_cast<std::uint32_t>(__builtin_wasm_any_true_v128(__builtin_bit_cast(Bytes, mask)));
#endif
    std::int32_t any = 0;
    for (std::uint32_t i = 0; i < N; ++i) any |= mask[i];
    return any != 0 ? 1u : 0u;
}

/// Stores the words of `v` in the lanes of `mask` one after the other, and returns their number. It may write N words.
template <std::uint32_t N>
TILEMESH_KERNEL std::uint32_t store_compressed(std::uint32_t* to, Words<N> const& v, Words<N> const& mask) noexcept
{
#if defined(__AVX512F__) && defined(__AVX512DQ__)
    if constexpr (N == 16) {
        auto const lanes = __builtin_ia32_cvtd2mask512(mask);
        store(to, __builtin_ia32_compresssi512_mask(v, Words<N>{}, lanes));
        return static_cast<std::uint32_t>(__builtin_popcount(lanes));
    }
#endif
    std::uint32_t n = 0;
    for (std::uint32_t i = 0; i < N; ++i) { // no branch: a predictor cannot know the lanes
        to[n] = static_cast<std::uint32_t>(v[i]);
        n -= static_cast<std::uint32_t>(mask[i]);
    }
    return n;
}

/// Stores four rows of four floats as four columns.
TILEMESH_KERNEL void store_transposed(Floats<4> const& a, Floats<4> const& b, Floats<4> const& c, Floats<4> const& d, float* x, float* y,
                                      float* z, float* w) noexcept
{
    Floats<4> const ab = __builtin_shufflevector(a, b, 0, 4, 1, 5), cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
    Floats<4> const ef = __builtin_shufflevector(a, b, 2, 6, 3, 7), gh = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    store(x, Floats<4>(__builtin_shufflevector(ab, cd, 0, 1, 4, 5)));
    store(y, Floats<4>(__builtin_shufflevector(ab, cd, 2, 3, 6, 7)));
    store(z, Floats<4>(__builtin_shufflevector(ef, gh, 0, 1, 4, 5)));
    store(w, Floats<4>(__builtin_shufflevector(ef, gh, 2, 3, 6, 7)));
}

/// a * b + c lane by lane, rounded as by the scalar `multiply_add`.
template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> multiply_add_lanes(Floats<N> const& a, Floats<N> const& b, Floats<N> const& c) noexcept
{
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA) || defined(__IPU__)
#    if defined(__IPU__)
    if constexpr (N == 2) return Floats<N>{__builtin_fmaf(a[0], b[0], c[0]), __builtin_fmaf(a[1], b[1], c[1])};
    Floats<N> r{};
    for (std::uint32_t i = 0; i < N; ++i) r[i] = __builtin_fmaf(a[i], b[i], c[i]);
    return r;
#    elif defined(__clang__)
    // One operation of whole vectors, which a target with the instruction always fuses: of calls for each lane, Clang 16 makes vectors of 4 and 8.
#        pragma clang fp contract(on)
    return a * b + c;
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

/// The same with one number for all lanes. GCC 12 makes a broadcast of a product's factor, but fills the lanes one by one where a whole vector is
/// asked for in a function that has more lanes than the compiler was called for.
template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> multiply_add_lanes(float a, Floats<N> const& b, Floats<N> const& c) noexcept
{
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA) || defined(__IPU__)
    return multiply_add_lanes<N>(broadcast<N>(a), b, c);
#else
    return a * b + c;
#endif
}

/// max(v, low); `low` for NaN.
template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> at_least(Floats<N> const& v, Floats<N> const& low) noexcept
{
#if defined(__AVX512F__) && !defined(__clang__)
    if constexpr (N == 16) return __builtin_ia32_maxps512_mask(v, low, v, static_cast<unsigned short>(0xffff), 4); // 4: the current rounding
#endif
#if defined(__AVX__)
    if constexpr (N == 8) return __builtin_ia32_maxps256(v, low); // GCC 12 would compare and select
#endif
#if defined(__SSE__)
    if constexpr (N == 4) return __builtin_ia32_maxps(v, low);
#endif
    return v > low ? v : low;
}
/// min(v, high); `high` for NaN.
template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> at_most(Floats<N> const& v, Floats<N> const& high) noexcept
{
#if defined(__AVX512F__) && !defined(__clang__)
    if constexpr (N == 16) return __builtin_ia32_minps512_mask(v, high, v, static_cast<unsigned short>(0xffff), 4);
#endif
#if defined(__AVX__)
    if constexpr (N == 8) return __builtin_ia32_minps256(v, high);
#endif
#if defined(__SSE__)
    if constexpr (N == 4) return __builtin_ia32_minps(v, high);
#endif
    return v < high ? v : high;
}
template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> between(Floats<N> const& v, Floats<N> const& low, Floats<N> const& high) noexcept
{
    return at_most<N>(at_least<N>(v, low), high);
}

/// |v|.
template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> magnitude(Floats<N> const& v) noexcept
{
    return floats_of<N>(bits_of<N>(v) & 0x7fffffff);
}

/// While an object of this class lives, its thread takes denormal numbers for 0. Then the thread has the caller's mode again, and in addition
/// the exception flags that the work raised. It does nothing on a target that it does not know. Do not copy it.
class DenormalsAreZero {
public:
    DenormalsAreZero() noexcept : before_(read()) { write(before_ | to_zero); }
    ~DenormalsAreZero() { write(before_ | (read() & exception_flags)); }

private:
#if defined(__SSE__)
    static constexpr std::uint32_t to_zero = 0x8040u, exception_flags = 0x003fu; // MXCSR: results and operands
    static std::uint32_t read() noexcept { return __builtin_ia32_stmxcsr(); }
    static void write(std::uint32_t mode) noexcept { __builtin_ia32_ldmxcsr(mode); }
#elif defined(__aarch64__)
    static constexpr std::uint32_t to_zero = 1u << 24, exception_flags = 0; // FPCR: results and operands; the flags are elsewhere
#    if defined(__clang__)
    static std::uint32_t read() noexcept { return __builtin_arm_rsr("fpcr"); }
    static void write(std::uint32_t mode) noexcept { __builtin_arm_wsr("fpcr", mode); }
#    else
    static std::uint32_t read() noexcept { return __builtin_aarch64_get_fpcr(); }
    static void write(std::uint32_t mode) noexcept { __builtin_aarch64_set_fpcr(mode); }
#    endif
#else
    static constexpr std::uint32_t to_zero = 0, exception_flags = 0;
    static std::uint32_t read() noexcept { return 0; }
    static void write(std::uint32_t) noexcept {}
#endif
    std::uint32_t before_;
};
/// In its place, where arithmetic stays normal.
struct DenormalsAsTheyAre {
    DenormalsAsTheyAre() noexcept {}
};

}}} // namespace tilemesh::splat::detail
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
