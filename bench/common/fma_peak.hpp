#pragma once
#include "statistics.hpp"
#include "team.hpp"
#include <cstdint>

namespace bench {

/// The peak of this build's widest vectors: independent multiply-adds in pinned registers, so that the measurement includes only the
/// arithmetic pipes. (A loop over an array of accumulators shows a seventh of the peak, because the compiler keeps them in memory.)
///
/// An FMA counts two operations per lane. Without FMA (SSE2), multiplications and additions alternate and count one each. On machines with
/// a separate pipe for each, this is twice the peak of either pipe.
struct FmaPeak {
#if defined(__AVX512F__)
    static constexpr char const* instructions = "AVX-512 FMA";
    static constexpr std::uint32_t chains = 20, lanes = 16, operations = 2;
#elif defined(__AVX2__) && defined(__FMA__)
    static constexpr char const* instructions = "AVX2 FMA";
    static constexpr std::uint32_t chains = 12, lanes = 8, operations = 2;
#elif defined(__SSE2__) && !defined(__AVX__)
    static constexpr char const* instructions = "SSE2 multiplications and additions";
    static constexpr std::uint32_t chains = 12, lanes = 4, operations = 1;
#else
    static constexpr char const* instructions = "not measured for this target";
    static constexpr std::uint32_t chains = 0, lanes = 0, operations = 0;
#endif
    static constexpr bool measured = chains != 0;

    /// Returns the GFLOP/s of all threads of the team together, over about a millisecond; 0 if it is not measured.
    static double gflops(Team& team)
    {
        if (!measured) return 0;
        // 60,000 times 12 to 20 instructions, of which one or two complete per cycle.
        constexpr std::uint32_t times = 60'000;
        team.run([](std::uint32_t) { multiply_add(100); });
        Stopwatch watch;
        team.run([](std::uint32_t) { multiply_add(times); });
        auto const ms = watch.lap();
        return double{times} * chains * lanes * operations * team.size() / (ms * 1e6);
    }

    /// Returns the clock of the team's threads in GHz, over about half a millisecond; 0 if it is not measured. Each multiplication of
    /// integers waits for the one before, which takes three cycles on x86-64 processors since 2008.
    static double clock_ghz([[maybe_unused]] Team& team)
    {
#if defined(__x86_64__)
        constexpr std::uint32_t times = 20'000, in_a_row = 32, cycles = 3;
        auto const chain = [](std::uint32_t) {
            std::uint64_t v = 3;
            for (std::uint32_t i = 0; i < times; ++i)
                asm volatile(".rept %c[n]\n imulq %[v], %[v]\n .endr\n" : [v] "+r"(v) : [n] "i"(in_a_row) : "cc");
        };
        Stopwatch watch;
        team.run(chain);
        return double{times} * in_a_row * cycles / (watch.lap() * 1e6);
#else
        return 0;
#endif
    }

private:
    /// x = 1 - x in every lane of every chain: values change and stay normal.
    static void multiply_add([[maybe_unused]] std::uint64_t times) noexcept
    {
        [[maybe_unused]] float const one = 1.0f, minus_one = -1.0f;
#if defined(__AVX512F__)
        asm volatile("vbroadcastss %[one], %%zmm30\n"
                     "vbroadcastss %[minus_one], %%zmm31\n"
                     ".irp i,0,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,18,19\n"
                     "vpxord %%zmm\\i, %%zmm\\i, %%zmm\\i\n"
                     ".endr\n"
                     "1:\n"
                     ".irp i,0,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,18,19\n"
                     "vfmadd213ps %%zmm30, %%zmm31, %%zmm\\i\n"
                     ".endr\n"
                     "dec %[times]\n"
                     "jnz 1b\n"
                     "vzeroupper\n"
                     : [times] "+r"(times)
                     : [one] "m"(one), [minus_one] "m"(minus_one)
                     : "zmm0", "zmm1", "zmm2", "zmm3", "zmm4", "zmm5", "zmm6", "zmm7", "zmm8", "zmm9", "zmm10", "zmm11",
                       "zmm12", "zmm13", "zmm14", "zmm15", "zmm16", "zmm17", "zmm18", "zmm19", "zmm30", "zmm31", "cc");
#elif defined(__AVX2__) && defined(__FMA__)
        asm volatile("vbroadcastss %[one], %%ymm14\n"
                     "vbroadcastss %[minus_one], %%ymm15\n"
                     ".irp i,0,1,2,3,4,5,6,7,8,9,10,11\n"
                     "vxorps %%ymm\\i, %%ymm\\i, %%ymm\\i\n"
                     ".endr\n"
                     "1:\n"
                     ".irp i,0,1,2,3,4,5,6,7,8,9,10,11\n"
                     "vfmadd213ps %%ymm14, %%ymm15, %%ymm\\i\n"
                     ".endr\n"
                     "dec %[times]\n"
                     "jnz 1b\n"
                     "vzeroupper\n"
                     : [times] "+r"(times)
                     : [one] "m"(one), [minus_one] "m"(minus_one)
                     : "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "xmm6", "xmm7", "xmm8", "xmm9", "xmm10", "xmm11",
                       "xmm14", "xmm15", "cc");
#elif defined(__SSE2__) && !defined(__AVX__)
        // Six chains of each operation: x = -x, and 0 + 0, which cannot leave the range of floats.
        asm volatile("movss %[minus_one], %%xmm14\n"
                     "shufps $0, %%xmm14, %%xmm14\n"
                     ".irp i,6,7,8,9,10,11,15\n"
                     "xorps %%xmm\\i, %%xmm\\i\n"
                     ".endr\n"
                     ".irp i,0,1,2,3,4,5\n"
                     "movaps %%xmm14, %%xmm\\i\n"
                     ".endr\n"
                     "1:\n"
                     "mulps %%xmm14, %%xmm0\naddps %%xmm15, %%xmm6\n"
                     "mulps %%xmm14, %%xmm1\naddps %%xmm15, %%xmm7\n"
                     "mulps %%xmm14, %%xmm2\naddps %%xmm15, %%xmm8\n"
                     "mulps %%xmm14, %%xmm3\naddps %%xmm15, %%xmm9\n"
                     "mulps %%xmm14, %%xmm4\naddps %%xmm15, %%xmm10\n"
                     "mulps %%xmm14, %%xmm5\naddps %%xmm15, %%xmm11\n"
                     "dec %[times]\n"
                     "jnz 1b\n"
                     : [times] "+r"(times)
                     : [minus_one] "m"(minus_one)
                     : "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "xmm6", "xmm7", "xmm8", "xmm9", "xmm10", "xmm11",
                       "xmm14", "xmm15", "cc");
#endif
    }
};

} // namespace bench
