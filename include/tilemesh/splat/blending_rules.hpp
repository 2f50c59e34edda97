#pragma once
#include <tilemesh/splat/counts.hpp>
#include <tilemesh/splat/exponential.hpp>
#include <tilemesh/splat/instruction_sets.hpp>
#include <tilemesh/splat/lanes.hpp>

/// The rules that blending takes as types: how it evaluates a pair of a splat and a pixel, and when a pixel stops. `precise` blends blocks
/// (blending_block.hpp), `fast` blends cells (blending_cells.hpp).
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The size of a block, in pixels.
inline constexpr std::uint32_t block_width = 16, block_height = 5;
/// The size of a cell, in pixels.
inline constexpr std::uint32_t cell_width = 8, cell_height = 4;
/// The Gaussian-pixel pairs of one call.
struct PairCount {
    std::uint32_t evaluated;    ///< in units of pairs_a_count
    std::uint32_t contributing; ///< pairs that passed both cut-offs
};

namespace detail {
/// The number of splats that a block or a cell blends before it checks whether all its pixels have stopped. 64 is early enough for walls of
/// opaque splats (tests/stability/opacity.cpp, row 55), and the check is rare enough to cost nothing.
inline constexpr std::uint32_t blended_between_looks = 64;
/// The alignment of data that is read and written as vectors: a vector that straddles two cache lines costs two accesses.
inline constexpr std::uint32_t vector_bytes = most_native_lanes * sizeof(float);

/// Evaluates every pair on its own, as the naive loop does. The bits are those of the naive loop.
struct EachPair {
    static constexpr bool in_cells = false;
    using Denormals = DenormalsAsTheyAre; // lowest_power_for keeps alpha normal
};
/// Evaluates a column of a cell by recurrence: two powers for four rows. `Degree` is the degree of the polynomial for 2^x.
template <int Degree>
struct Recurrence {
    static constexpr bool in_cells = true;
    /// A column far from a small splat leaves the normal numbers, in its first row or below it. Its alpha is below the cut, whether it is
    /// denormal or 0.
    using Denormals = DenormalsAreZero;
    static constexpr int degree = Degree;
};
using FastRule = Recurrence<5>;

/// A pixel stops when its own transmittance is below the limit: Stop::after_crossing.
struct StopEachPixel {
    static constexpr bool each_pixel = true, drops_crossing = false;
};
/// A pixel stops before the splat that would take its transmittance below the limit, and does not blend that splat: Stop::before_crossing,
/// the rule of 3D Gaussian Splatting. One rounding decides whether (tests/stability/opacity.cpp, rows 45 and 46). A stopped pixel keeps its
/// transmittance with the sign turned in a block or a cell.
struct StopBeforeCrossing {
    static constexpr bool each_pixel = true, drops_crossing = true;
};
/// The rule that the rules of the picture ask for, chosen batch by batch of a cell: so only the loops over pixels are there twice.
struct StopAsAsked {};

/// Coefficient k of the polynomial for 2^x. The polynomials have the least relative error on [-1/2, 1/2] (Remez): 7.5e-5 at degree 3, 2.6e-6
/// at degree 4, 7.5e-8 at degree 5, before rounding.
template <int Degree, std::uint32_t N>
TILEMESH_KERNEL Floats<N> coefficient(int k) noexcept
{
    constexpr float c[3][6] = {{0.999928057f, 0.693260968f, 0.242611125f, 0.0551716685f, 0, 0},
                               {0.999999285f, 0.693121791f, 0.240247443f, 0.0559178591f, 0.00957010221f, 0},
                               {1.00000012f, 0.693146944f, 0.240221202f, 0.0555071309f, 0.00967554096f, 0.00132764725f}};
    return broadcast<N>(c[Degree - 3][k]);
}
/// 2^r for |r| <= 1/2.
template <int Degree, std::uint32_t N>
TILEMESH_KERNEL Floats<N> polynomial(Floats<N> const& r) noexcept
{
    static_assert(Degree >= 3 && Degree <= 5, "polynomials of degree 3, 4 and 5 are known");
    Floats<N> p = coefficient<Degree, N>(Degree);
#if defined(__clang__)
    for (int i = Degree; i-- > 0;) p = multiply_add_lanes<N>(p, r, coefficient<Degree, N>(i)); // written out, Clang 16 would spill more registers
#else
    if constexpr (Degree > 4)
        p = multiply_add_lanes<N>(p, r, coefficient<Degree, N>(4)); // a loop, GCC 12 would keep it, with the coefficients on the stack
    if constexpr (Degree > 3) p = multiply_add_lanes<N>(p, r, coefficient<Degree, N>(3));
    p = multiply_add_lanes<N>(p, r, coefficient<Degree, N>(2));
    p = multiply_add_lanes<N>(p, r, coefficient<Degree, N>(1));
    p = multiply_add_lanes<N>(p, r, coefficient<Degree, N>(0));
#endif
    return p;
}
/// 2^x for |x| <= 126.
template <int Degree, std::uint32_t N>
TILEMESH_KERNEL Floats<N> power_of_two(Floats<N> const& x) noexcept
{
    constexpr float to_integer = 12582912.0f; // 1.5 * 2^23: adding it rounds to the nearest integer
    Floats<N> const shifted = x + to_integer;
    Floats<N> const p = polynomial<Degree, N>(x - (shifted - to_integer));
    return floats_of<N>(bits_of<N>(p) + (bits_of<N>(shifted) << 23));
}

/// Tells the host's caches that splats [first, last) are read soon. Called for a chunk while the chunk before it is blended: waiting for
/// scattered records would take up to a tenth of a frame.
template <class SplatAt>
TILEMESH_KERNEL void fetch_ahead(std::uint32_t first, std::uint32_t last, SplatAt const& at) noexcept
{
    for (std::uint32_t i = first; i < last; ++i) {
        auto const& s = at(i);
        __builtin_prefetch(&s);
        __builtin_prefetch(reinterpret_cast<char const*>(&s) + sizeof s - 1);
    }
}
/// `fetch_ahead` for part `part` of `parts` of the chunk that begins at `begin`.
template <std::uint32_t Size, class SplatAt>
TILEMESH_KERNEL void fetch_part_ahead(std::uint32_t begin, std::uint32_t n, std::uint32_t part, std::uint32_t parts, SplatAt const& at) noexcept
{
    std::uint32_t const first = begin + Size * part / parts, last = begin + Size * (part + 1) / parts;
    fetch_ahead(first, last < n ? last : n, at);
}
/// Tells the host's caches that pixels [x0, x1) of a row are written soon.
template <class Pixel>
void fetch_row_ahead(Pixel* row, std::uint32_t x0, std::uint32_t x1) noexcept
{
    constexpr std::uint32_t line_px = sizeof(Pixel) < 64 ? 64 / sizeof(Pixel) : 1; // a cache line, rounded down
    for (std::uint32_t x = x0; x < x1; x += line_px) __builtin_prefetch(row + x, 1);
    __builtin_prefetch(row + (x1 - 1), 1);
}
} // namespace detail

}}} // namespace tilemesh::splat
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
