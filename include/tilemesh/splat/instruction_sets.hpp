#pragma once
#include <cstdint>
#include <tilemesh/splat/lanes.hpp>
#include <type_traits>

#if TILEMESH_INSTRUCTION_SETS && !defined(__clang__)
// GCC says where a template is instantiated, often at the end of the user's file, that the result of a function is a wider vector than the
// compiler was called for. These functions are always inlined (lanes.hpp). So the warning stays off, also after this header.
// GCC forgets that in a program that precompiles this header; such a program needs -Wno-psabi.
#    pragma GCC diagnostic ignored "-Wpsabi"
#endif

/// The instruction sets of the hot functions. A program for any x86-64 compiles projection and blending on host threads for several sets, asks
/// the processor at run time, and uses the widest set that the processor has. Every other build has one set (TILEMESH_INSTRUCTION_SETS).
///
/// All sets round as the build does, which has no fused multiplication. So pictures have the same bits on every processor, and `precise`
/// arithmetic has the bits of the naive loop.
TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace splat {

/// `given` is the set that the compiler was called with. `avx512` is AVX-512 F, BW, DQ and VL; only Clang compiles for it, see `Avx512Set`.
enum class InstructionSet : std::uint32_t { given, avx2, avx512 };

namespace detail {
/// A set of instructions has a function `call<Work>(arguments...)`. It calls `Work::run<Set>(arguments...)`, which is TILEMESH_KERNEL: it is
/// inlined and so gets the instructions of `call`. `call` itself is never inlined. It passes references, because how a vector is passed
/// depends on the instructions.
///
/// This one has the instructions that the compiler was called with, on N lanes.
template <std::uint32_t N>
struct GivenSet {
    static constexpr std::uint32_t most_lanes = N;
    static constexpr bool compresses = false; // store_compressed does
#if defined(__wasm__)
    static constexpr bool blends_rows_apart = true; // a browser on x86-64 has 16 registers of four lanes, and the rows of a strip take 20
#else
    static constexpr bool blends_rows_apart = false;
#endif

    static constexpr std::uint32_t lanes() noexcept { return N; }
    template <class Work, class... Args>
    [[gnu::noinline]] static auto call(Args&&... args) noexcept
    {
        return Work::template run<GivenSet>(args...);
    }
};

#if TILEMESH_INSTRUCTION_SETS
struct Avx2Set {
    static constexpr std::uint32_t most_lanes = 8;
    static constexpr bool compresses = false, blends_rows_apart = false;

    template <class Work, class... Args>
    [[gnu::noinline, gnu::target("avx2")]] static auto call(Args&&... args) noexcept
    {
        return Work::template run<Avx2Set>(args...);
    }
};
#    if defined(__clang__)
/// Not with GCC: it chooses how to represent the result of a compare before it inlines, by the instructions that it was called with. What it
/// chooses there is computed one lane after the other with AVX-512.
struct Avx512Set {
    static constexpr std::uint32_t most_lanes = 16;
    static constexpr bool compresses = true, blends_rows_apart = false;

    template <class Work, class... Args>
    [[gnu::noinline, gnu::target("avx512f,avx512bw,avx512dq,avx512vl")]] static auto call(Args&&... args) noexcept
    {
        return Work::template run<Avx512Set>(args...);
    }
    /// Stores those of n words whose mask is set one after the other, and returns their number. It may read and write 15 words more.
    [[gnu::noinline, gnu::target("avx512f,avx512dq")]] static std::uint32_t compress(std::uint32_t* to, std::int32_t const* words,
                                                                                     std::int32_t const* masks, std::uint32_t n) noexcept
    {
        std::uint32_t count = 0;
        for (std::uint32_t i = 0; i < n; i += 16) {
            Words<16> v, mask;
            std::memcpy(&v, words + i, sizeof v);
            std::memcpy(&mask, masks + i, sizeof mask);
            auto const lanes = __builtin_ia32_cvtd2mask512(mask);
            v = __builtin_ia32_compresssi512_mask(v, Words<16>{}, lanes);
            std::memcpy(to + count, &v, sizeof v);
            count += static_cast<std::uint32_t>(__builtin_popcount(lanes));
        }
        return count;
    }
};
#    endif

inline InstructionSet widest_set() noexcept
{
#    if defined(__clang__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl"))
        return InstructionSet::avx512;
#    endif
    return __builtin_cpu_supports("avx2") ? InstructionSet::avx2 : InstructionSet::given;
}
/// This and its users are templates, so that programs without host threads have no such word.
template <class>
struct SetInUse {
    static inline InstructionSet value = widest_set();
};

/// The set in use.
template <class Program = void>
class ChosenSet {
public:
    static constexpr std::uint32_t most_lanes = 16;

    std::uint32_t lanes() const noexcept
    {
        return set_ == InstructionSet::avx512 ? most_lanes : set_ == InstructionSet::avx2 ? Avx2Set::most_lanes : native_lanes;
    }
    template <class Work, class... Args>
    auto call(Args&&... args) const noexcept
    {
#    if defined(__clang__)
        if (set_ == InstructionSet::avx512) return Avx512Set::call<Work>(args...);
#    endif
        if (set_ == InstructionSet::avx2) return Avx2Set::call<Work>(args...);
        return GivenSet<native_lanes>::call<Work>(args...);
    }

private:
    InstructionSet set_ = SetInUse<Program>::value;
};

/// Stands for the lanes of the set in use, where a function takes a number of lanes.
inline constexpr std::uint32_t lanes_in_use = 0;
template <std::uint32_t N>
using SetOf = std::conditional_t<N == lanes_in_use, ChosenSet<>, GivenSet<N == lanes_in_use ? native_lanes : N>>;
#else
inline constexpr std::uint32_t lanes_in_use = native_lanes;
template <std::uint32_t N>
using SetOf = GivenSet<N>;
#endif
} // namespace detail

/// The instruction set that the hot functions use now.
template <class Program = void>
InstructionSet instruction_set() noexcept
{
#if TILEMESH_INSTRUCTION_SETS
    return detail::SetInUse<Program>::value;
#else
    return InstructionSet::given;
#endif
}

/// Takes another set from now on, in the whole program. Returns false, and changes nothing, if the processor or the build does not have
/// the set. It is for tests and measurements: no bit of a result changes. Do not call it while a frame is rendered.
template <class Program = void>
bool use_instruction_set(InstructionSet set) noexcept
{
#if TILEMESH_INSTRUCTION_SETS
    if (set == InstructionSet::avx512 && detail::widest_set() != set) return false;
    if (set == InstructionSet::avx2 && !__builtin_cpu_supports("avx2")) return false;
    detail::SetInUse<Program>::value = set;
    return true;
#else
    return set == InstructionSet::given;
#endif
}

}}} // namespace tilemesh::splat
TILEMESH_EXACT_END
