#pragma once
#include <cmath>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/splat/exponential.hpp>
#include <tilemesh/splat/lanes.hpp>
#include <tilemesh/splat/policies.hpp>
#include <type_traits>

/// Blends a list of splats, front to back, into a rectangle of pixels: what a tile does with its sorted splats, and all that a
/// rasteriser without tiles needs.
///
/// Pixels are blended in blocks of 16 x 5 that lie on the frame's pixel grid, whatever the tiling: a block that a tile border
/// cuts is evaluated whole and masked. 16 x 5 divides the paper's 32 x 20 tile, and the 20 vectors of a block's state stay in
/// registers where there are 32 of 16 lanes. A block passes over the splats some at a time: a test over `Lanes` splats at once
/// finds those that a pixel of the block may see, and these are blended one after the other into 5 rows.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh::splat {

/// Gaussian-pixel pairs of one call, as counted by it.
struct PairCount {
    std::uint32_t blocks;       ///< evaluated, in blocks of block_width x block_height pixels: whole frames fit into 32 bits
    std::uint32_t contributing; ///< pairs that passed both cut-offs
};

/// Pixels of a block.
inline constexpr std::uint32_t block_width = 16, block_height = 5;

namespace detail {
/// Of what is read and written as vectors: one that straddles two cache lines costs two accesses.
inline constexpr std::uint32_t vector_bytes = native_lanes * sizeof(float);

// --- arithmetics ------------------------------------------------------------------------------------------------------------

/// Every pair by itself, as the naive loop does: equal bits.
struct EachPair {
    static constexpr bool recurs = false;
};
/// Down a column of the block alpha is a Gaussian of the row, so that each ratio of neighbours is the last one times a constant
/// q = 2^(2 across): two exponentials for five rows. `Degree` is that of 2^x's polynomial. Splats that are not tame in a block
/// are evaluated pair by pair.
template <int Degree>
struct Recurrence {
    static constexpr bool recurs = true;
    static constexpr int degree = Degree;
};
/// A splat is tame in a block where alpha rises by less than 2^steepest_rise from the first row to any other. The exponent of the
/// first row is clamped at -126. A column that this changes has less than 2^(steepest_rise - 126) = 2^-14 in every row, which
/// is below `faintest_cut`, and stays below it; in all others nothing is clamped, and the rounding of an exponent of 126 is
/// 2^-18 of the value.
inline constexpr float steepest_rise = 112.0f, faintest_cut = 0x1p-13f;
/// And where no term of the distance across the splat, in pixels, exceeds this: of a needle whose mean is far from the frame the
/// distance may be nothing but the rounding of its terms, which is another one in every row.
inline constexpr float farthest_px = 512.0f;
/// alpha of a tame splat is below its opacity by more than the recurrence's error, 2^-16: it can exceed neither alpha_max nor 1.
inline constexpr float below_the_clamp = 1.0f - 0x1p-16f;
using FastRule = Recurrence<5>;

/// A pixel stops when its own transmittance is below the limit, as the model says.
struct StopEachPixel {
    static constexpr bool each_pixel = true, drops_crossing = false;
};
/// All pixels of a block go on until the last one has stopped. Not the model: measured beside it (bench/frame).
struct StopWholeBlock {
    static constexpr bool each_pixel = false, drops_crossing = false;
};
/// A pixel stops before the splat that would take its transmittance below the limit, which it leaves out, as 3D Gaussian Splatting
/// does. Not the model: it loses up to the limit at once, and one rounding decides whether (numerics, rows 45 and 46); measured
/// beside it (bench/error_vs_time). What a stopped pixel keeps of its transmittance has its sign turned.
struct StopBeforeCrossing {
    static constexpr bool each_pixel = true, drops_crossing = true;
};

/// 2^x for |x| <= 126. The polynomials are those of
/// least relative error on [-1/2, 1/2] (Remez): 7.5e-5 at degree 3, 2.6e-6 at 4, 7.5e-8 at 5, before rounding.
template <int Degree, std::uint32_t N>
TILEMESH_KERNEL Floats<N> power_of_two(Floats<N> const& x) noexcept
{
    static_assert(Degree >= 3 && Degree <= 5, "polynomials of degree 3, 4 and 5 are known");
    constexpr float to_integer = 12582912.0f; // 1.5 * 2^23: adding it rounds to the nearest integer
    Floats<N> const shifted = x + to_integer;
    Floats<N> const r = x - (shifted - to_integer);
    constexpr float c[3][6] = {{0.999928057f, 0.693260968f, 0.242611125f, 0.0551716685f, 0, 0},
                               {0.999999285f, 0.693121791f, 0.240247443f, 0.0559178591f, 0.00957010221f, 0},
                               {1.00000012f, 0.693146944f, 0.240221202f, 0.0555071309f, 0.00967554096f, 0.00132764725f}};
    Floats<N> p = broadcast<N>(c[Degree - 3][Degree]);
    for (int i = Degree; i-- > 0;) p = multiply_add_lanes<N>(p, r, broadcast<N>(c[Degree - 3][i]));
    return floats_of<N>(bits_of<N>(p) + (bits_of<N>(shifted) << 23));
}

// --- one block ----------------------------------------------------------------------------------------------------------------

/// The state of a block while it is blended, row by row. Dead lanes, outside the tile, have a negative transmittance.
struct alignas(vector_bytes) Block {
    float transmittance[block_height][block_width];
    float red[block_height][block_width];
    float green[block_height][block_width];
    float blue[block_height][block_width];
    static constexpr bool has_depth = false;
};
struct DepthBlock : Block {
    float weight[block_height][block_width];
    float depth[block_height][block_width];
    static constexpr bool has_depth = true;
};

/// Some splats, field by field.
template <std::uint32_t Size>
struct alignas(vector_bytes) Chunk {
    static constexpr std::uint32_t size = Size;
    float mean_x[size], mean_y[size];
    float along[size], slope[size], across[size], opacity[size];
    float red[size], green[size], blue[size], depth[size];
    float faintest[size];
    float steepest[size]; ///< across slope / (along + across slope^2): times y, the x of the best point on a horizontal edge
    float q[size];        ///< 2^(2 across) of the recurrence
    std::int32_t x0[size], x1[size], y0[size], y1[size];

    void take(std::uint32_t i, Splat const& s) noexcept
    {
        mean_x[i] = s.mean_px[0];
        mean_y[i] = s.mean_px[1];
        along[i] = s.along;
        slope[i] = s.slope;
        across[i] = s.across;
        opacity[i] = s.opacity;
        red[i] = s.colour[0];
        green[i] = s.colour[1];
        blue[i] = s.colour[2];
        depth[i] = s.depth;
        faintest[i] = s.faintest;
        x0[i] = static_cast<std::int32_t>(s.columns & 0xffffu);
        x1[i] = static_cast<std::int32_t>(s.columns >> 16);
        y0[i] = static_cast<std::int32_t>(s.rows & 0xffffu);
        y1[i] = static_cast<std::int32_t>(s.rows >> 16);
    }
    /// What follows from the fields of the first n splats, and of what fills their last lanes.
    template <class Rule, std::uint32_t N>
    void complete(std::uint32_t n) noexcept
    {
        constexpr float two_log2_e = 2 * 1.44269504088896341f;
        for (std::uint32_t i = 0; i < n; i += N) {
            Floats<N> const k = load<N>(slope + i), steep = load<N>(across + i) * k;
            store(steepest + i, Floats<N>(steep / (load<N>(along + i) + steep * k)));
            if constexpr (Rule::recurs) {
                Floats<N> const exponent = load<N>(across + i) * two_log2_e; // never above 0
                store(q + i, power_of_two<Rule::degree, N>(exponent > -126.0f ? exponent : broadcast<N>(-126.0f)));
            }
        }
    }
};

template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> clamped(Floats<N> const& v, Floats<N> const& low, Floats<N> const& high) noexcept
{
    return v < low ? low : v > high ? high : v;
}
template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> magnitude(Floats<N> const& v) noexcept
{
    return floats_of<N>(bits_of<N>(v) & 0x7fffffff);
}
/// How far v is from w beyond what rounding makes of two such numbers (2^-21 of them: 8 roundings); 0 for NaN. Of a needle whose
/// mean is far from the frame, v - w may be nothing but rounding.
template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> beyond_rounding(Floats<N> const& v, Floats<N> const& w) noexcept
{
    Floats<N> const rounding = 0x1p-21f * (magnitude<N>(v) + magnitude<N>(w)), distance = magnitude<N>(v - w);
    return distance > rounding ? distance - rounding : Floats<N>{};
}

/// May a pixel of a block see these splats? The largest power over the block's pixel centres, from the point of the block
/// nearest to the mean in the splat's own metric: never wrong to say yes, and the margin (2 % of alpha and 1e-4 of the power)
/// is far above the rounding of either side. (x0, x1, y0, y1): the block's outermost pixel centres relative to the means.
template <std::uint32_t N, std::uint32_t Size>
TILEMESH_KERNEL Words<N> reaches(Chunk<Size> const& c, std::uint32_t i, Floats<N> const& x0, Floats<N> const& x1,
                                 Floats<N> const& y0, Floats<N> const& y1) noexcept
{
    auto const along = load<N>(c.along + i), slope = load<N>(c.slope + i), across = load<N>(c.across + i);
    // On the side of the block that faces the mean, the best point of the vertical and of the horizontal edge.
    auto const x = clamped<N>(Floats<N>{}, x0, x1), y = clamped<N>(Floats<N>{}, y0, y1);
    auto const best_y = clamped<N>(slope * x, y0, y1);
    auto const off1 = beyond_rounding<N>(best_y, slope * x);
    auto const power1 = along * x * x + across * off1 * off1;
    auto const best_x = clamped<N>(load<N>(c.steepest + i) * y, x0, x1);
    auto const off2 = beyond_rounding<N>(y, slope * best_x);
    auto const power2 = along * best_x * best_x + across * off2 * off2;
    auto const power = power1 > power2 ? power1 : power2;
    return ~(power * (1.0f - 1e-4f) + 0.02f < load<N>(c.faintest + i)); // NaN says yes
}

/// Is the splat tame in a block? The ratio of the first two rows is 2 to the power of something linear in the column: its extremes
/// are at the ends. What alpha_max would clamp is not, because clamping rounds no ratio. NaN says no.
template <std::uint32_t N, std::uint32_t Size>
TILEMESH_KERNEL Words<N> is_tame(Chunk<Size> const& c, std::uint32_t i, Floats<N> const& x0, Floats<N> const& x1,
                                 Floats<N> const& y0, float alpha_max) noexcept
{
    constexpr float log2_e = 1.44269504088896341f;
    auto const slope = load<N>(c.slope + i), across = load<N>(c.across + i) * log2_e;
    auto const across0 = slope * x0, across1 = slope * x1, off0 = y0 - across0, off1 = y0 - across1;
    auto const least = off0 < off1 ? off0 : off1; // across is negative: the steepest rise is where `off` is least
    auto const rise = across * (least + least + 1.0f);
    // To row k: k rise + k (k - 1) across.
    return (rise < steepest_rise) & (2.0f * (rise + across) < steepest_rise) & (3.0f * (rise + 2.0f * across) < steepest_rise) &
           (4.0f * (rise + 3.0f * across) < steepest_rise) & (magnitude<N>(y0) < farthest_px) &
           (magnitude<N>(across0) < farthest_px) & (magnitude<N>(across1) < farthest_px) &
           (load<N>(c.opacity + i) <= alpha_max * below_the_clamp);
}

/// Which rows of a block a splat covers that covers [first, last) of them: all bits of a row or none.
struct CoveredRows {
    static constexpr std::uint32_t patterns = (block_height + 1) * (block_height + 1);
    std::uint32_t bits[patterns * block_height];
    constexpr CoveredRows() noexcept : bits{}
    {
        for (std::uint32_t i = 0; i < patterns * block_height; ++i) {
            std::uint32_t const first = i / block_height / (block_height + 1), last = i / block_height % (block_height + 1);
            bits[i] = i % block_height >= first && i % block_height < last ? 0xffffffffu : 0u;
        }
    }
};
inline constexpr CoveredRows covered_rows{};

/// The least alpha of each row, by pattern: alpha_min in the rows that a splat covers, infinity in the others.
struct RowLimits {
    float alpha[CoveredRows::patterns * block_height];
    explicit RowLimits(float alpha_min) noexcept
    {
        auto const least = __builtin_bit_cast(std::uint32_t, alpha_min);
        constexpr std::uint32_t infinity = 0x7f800000u;
        for (std::uint32_t i = 0; i < CoveredRows::patterns * block_height; ++i)
            alpha[i] = __builtin_bit_cast(float, infinity ^ ((infinity ^ least) & covered_rows.bits[i]));
    }
    float const* of(std::uint32_t pattern) const noexcept { return alpha + pattern * block_height; }
};

/// What a block needs to know besides its state and its splats.
struct alignas(vector_bytes) BlockPlace {
    float xs[block_width];              ///< pixel centres relative to the principal point
    float ys[block_height];
    std::int32_t column, row;           ///< of its first pixel
};

/// A splat that a block blends: its number in the chunk, whether the recurrence may be used, and the number of its RowLimits.
struct Hit {
    static constexpr std::uint32_t number = 0xffu, recurs = 0x100u, limits_at = 16;
};

/// Lists the splats of a chunk that a pixel of the block may see; returns how many. Requires room for one more.
template <class Rule, std::uint32_t N, std::uint32_t Size>
std::uint32_t list_hits(Chunk<Size> const& c, std::uint32_t n, BlockPlace const& at, float alpha_max, std::uint32_t* hits) noexcept
{
    constexpr std::int32_t rows = static_cast<std::int32_t>(block_height);
    alignas(vector_bytes) std::int32_t entries[Size]; // negative: no pixel sees the splat
    for (std::uint32_t i = 0; i < n; i += N) {
        auto const mean_x = load<N>(c.mean_x + i), mean_y = load<N>(c.mean_y + i);
        Floats<N> const x0 = at.xs[0] - mean_x, x1 = at.xs[block_width - 1] - mean_x;
        Floats<N> const y0 = at.ys[0] - mean_y, y1 = at.ys[block_height - 1] - mean_y;
        Words<N> first = load_words<N>(c.y0 + i) - at.row, last = load_words<N>(c.y1 + i) - at.row;
        Words<N> const unseen = ~(reaches<N>(c, i, x0, x1, y0, y1) & (first < rows) & (last > 0) &
                                  (load_words<N>(c.x0 + i) < at.column + static_cast<std::int32_t>(block_width)) &
                                  (load_words<N>(c.x1 + i) > at.column));
        first = first > 0 ? first : Words<N>{};
        last = last < rows ? last : broadcast_word<N>(rows);
        Words<N> entry = (first * (rows + 1) + last) << static_cast<std::int32_t>(Hit::limits_at);
        if constexpr (Rule::recurs) entry |= is_tame<N>(c, i, x0, x1, y0, alpha_max) & static_cast<std::int32_t>(Hit::recurs);
        store(entries + i, Words<N>(entry | unseen));
    }
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < n; ++i) { // without a branch: every second splat is seen
        hits[count] = static_cast<std::uint32_t>(entries[i]) | i;
        count += entries[i] >= 0 ? 1u : 0u;
    }
    hits[count] = 0; // looked at, never blended
    return count;
}

/// N columns of a block in registers.
template <std::uint32_t N, bool HasDepth>
struct Strip {
    Floats<N> t[block_height], r[block_height], g[block_height], b[block_height];
    Floats<N> w[HasDepth ? block_height : 1], z[HasDepth ? block_height : 1];
    Words<N> contributing;
};
template <std::uint32_t N>
struct LaneColour {
    Floats<N> r, g, b, z;
};

/// Blends one row: C += w c, T -= w with w = alpha T where the pair takes part. A lane that takes no part adds 0, which
/// changes no bit.
template <class Stop, std::uint32_t K, std::uint32_t N, bool HasDepth>
TILEMESH_KERNEL void blend_row(Strip<N, HasDepth>& s, Floats<N> const& alpha, Model const& m, float const* least,
                               LaneColour<N> const& c) noexcept
{
    Words<N> takes_part = alpha >= least[K];
    if constexpr (Stop::each_pixel)
        takes_part &= s.t[K] >= m.transmittance_min;
    else
        takes_part &= s.t[K] >= 0.0f;
    if constexpr (Stop::drops_crossing) {
        Floats<N> const share = alpha * s.t[K];
        Words<N> const crosses = takes_part & (s.t[K] - share < m.transmittance_min);
        s.t[K] = crosses ? -s.t[K] : s.t[K];
        takes_part &= ~crosses;
    }
    Floats<N> const weight = takes_part ? alpha * s.t[K] : Floats<N>{};
    s.r[K] = multiply_add_lanes<N>(weight, c.r, s.r[K]);
    s.g[K] = multiply_add_lanes<N>(weight, c.g, s.g[K]);
    s.b[K] = multiply_add_lanes<N>(weight, c.b, s.b[K]);
    s.t[K] = s.t[K] - weight;
    if constexpr (HasDepth) {
        s.w[K] = s.w[K] + weight;
        s.z[K] = multiply_add_lanes<N>(weight, c.z, s.z[K]);
    }
    s.contributing = takes_part ? s.contributing + 1 : s.contributing;
}

/// alpha of row K, as the naive loop computes it.
template <std::uint32_t K, std::uint32_t N, std::uint32_t Size>
TILEMESH_KERNEL Floats<N> alpha_of_row(Chunk<Size> const& c, std::uint32_t i, BlockPlace const& at, Floats<N> const& dx,
                                       Floats<N> const& opacity, float alpha_max) noexcept
{
    Floats<N> const dy = broadcast<N>(at.ys[K] - c.mean_y[i]);
    Floats<N> const off = multiply_add_lanes<N>(broadcast<N>(-c.slope[i]), dx, dy);
    Floats<N> const power = multiply_add_lanes<N>(c.along[i] * dx, dx, c.across[i] * off * off);
    Floats<N> const alpha = opacity * exponential_lanes<N>(power);
    return alpha < alpha_max ? alpha : broadcast<N>(alpha_max);
}

template <bool HasDepth, std::uint32_t N, std::uint32_t Size>
TILEMESH_KERNEL LaneColour<N> colour_of(Chunk<Size> const& c, std::uint32_t i) noexcept
{
    LaneColour<N> l{broadcast<N>(c.red[i]), broadcast<N>(c.green[i]), broadcast<N>(c.blue[i]), Floats<N>{}};
    if constexpr (HasDepth) l.z = broadcast<N>(c.depth[i]);
    return l;
}
/// The opacity; in columns outside the splat's rectangle negative, so that alpha is below any cut-off.
template <std::uint32_t N, std::uint32_t Size>
TILEMESH_KERNEL Floats<N> opacity_of(Chunk<Size> const& c, std::uint32_t i, Words<N> const& columns) noexcept
{
    auto const offset = __builtin_bit_cast(UnsignedWords<N>, Words<N>(columns - c.x0[i]));
    return offset < static_cast<std::uint32_t>(c.x1[i] - c.x0[i]) ? broadcast<N>(c.opacity[i]) : broadcast<N>(-1.0f);
}

/// alpha in the first row of a block, and its ratio to the second's.
template <std::uint32_t N>
struct FirstRow {
    Floats<N> alpha, ratio;
};
/// Of a splat that is not tame: no matter what.
template <class Rule, std::uint32_t N, std::uint32_t Size>
TILEMESH_KERNEL FirstRow<N> first_row(Chunk<Size> const& c, std::uint32_t hit, BlockPlace const& at, Floats<N> const& xs,
                                      Words<N> const& columns) noexcept
{
    constexpr float log2_e = 1.44269504088896341f;
    std::uint32_t const i = hit & Hit::number;
    float const across = c.across[i] * log2_e, along = c.along[i] * log2_e;
    Floats<N> const dx = xs - c.mean_x[i];
    Floats<N> const off = multiply_add_lanes<N>(broadcast<N>(-c.slope[i]), dx, broadcast<N>(at.ys[0] - c.mean_y[i]));
    Floats<N> const u = across * off;
    Floats<N> const power = multiply_add_lanes<N>(along * dx, dx, u * off), rise = u + u + across;
    auto const lowest = broadcast<N>(-126.0f);
    return {opacity_of<N>(c, i, columns) * power_of_two<Rule::degree, N>(power > lowest ? power : lowest),
            power_of_two<Rule::degree, N>(rise > lowest ? rise : lowest)};
}

/// Blends the splats of `hits` into N columns.
template <class Rule, class Stop, std::uint32_t N, bool HasDepth, std::uint32_t Size>
TILEMESH_KERNEL void blend_hits(Strip<N, HasDepth>& s, Chunk<Size> const& c, std::uint32_t const* hits, std::uint32_t n,
                                BlockPlace const& at, std::uint32_t column, Model const& m, RowLimits const& limits) noexcept
{
    static_assert(block_height == 5, "the rows below are written out: a loop would leave the registers");
    auto const xs = load<N>(at.xs + column);
    std::int32_t numbers[N];
    for (std::uint32_t k = 0; k < N; ++k) numbers[k] = at.column + static_cast<std::int32_t>(column + k);
    auto const columns = load_words<N>(numbers);
    if constexpr (Rule::recurs) {
        // The next splat's exponentials are on their way while this one's rows are blended: a chain of 80 cycles.
        auto now = first_row<Rule, N>(c, hits[0], at, xs, columns);
        for (std::uint32_t h = 0; h < n; ++h) {
            auto const next = first_row<Rule, N>(c, hits[h + 1], at, xs, columns);
            std::uint32_t const i = hits[h] & Hit::number;
            auto const l = colour_of<HasDepth, N>(c, i);
            float const* const least = limits.of(hits[h] >> Hit::limits_at);
            Floats<N> const q = broadcast<N>(c.q[i]);
            Floats<N> alpha = now.alpha, ratio = now.ratio;
            blend_row<Stop, 0, N>(s, alpha, m, least, l);
            alpha = alpha * ratio, ratio = ratio * q;
            blend_row<Stop, 1, N>(s, alpha, m, least, l);
            alpha = alpha * ratio, ratio = ratio * q;
            blend_row<Stop, 2, N>(s, alpha, m, least, l);
            alpha = alpha * ratio, ratio = ratio * q;
            blend_row<Stop, 3, N>(s, alpha, m, least, l);
            alpha = alpha * ratio;
            blend_row<Stop, 4, N>(s, alpha, m, least, l);
            now = next;
        }
    } else {
        for (std::uint32_t h = 0; h < n; ++h) {
            std::uint32_t const i = hits[h] & Hit::number;
            auto const l = colour_of<HasDepth, N>(c, i);
            float const* const least = limits.of(hits[h] >> Hit::limits_at);
            Floats<N> const dx = xs - c.mean_x[i], opacity = opacity_of<N>(c, i, columns);
            blend_row<Stop, 0, N>(s, alpha_of_row<0, N>(c, i, at, dx, opacity, m.alpha_max), m, least, l);
            blend_row<Stop, 1, N>(s, alpha_of_row<1, N>(c, i, at, dx, opacity, m.alpha_max), m, least, l);
            blend_row<Stop, 2, N>(s, alpha_of_row<2, N>(c, i, at, dx, opacity, m.alpha_max), m, least, l);
            blend_row<Stop, 3, N>(s, alpha_of_row<3, N>(c, i, at, dx, opacity, m.alpha_max), m, least, l);
            blend_row<Stop, 4, N>(s, alpha_of_row<4, N>(c, i, at, dx, opacity, m.alpha_max), m, least, l);
        }
    }
}

/// Blends the splats of `hits` into a block, all by one rule; returns how many pairs contributed. A function of its own for each
/// rule, so that each has all registers.
template <class Rule, class Stop, std::uint32_t N, class AnyBlock, std::uint32_t Size>
[[gnu::noinline]] std::uint32_t blend_block(AnyBlock& block, Chunk<Size> const& c, std::uint32_t const* hits, std::uint32_t n,
                                            BlockPlace const& at, Model const& m, RowLimits const& limits) noexcept
{
    // Keeps the stack frame on vector bounds: Clang would let the vectors that it spills straddle two cache lines, by chance.
    [[maybe_unused]] alignas(vector_bytes) volatile std::uint32_t const on_bounds = 0;
    std::uint32_t contributing = 0;
    for (std::uint32_t column = 0; column < block_width; column += N) {
        Strip<N, AnyBlock::has_depth> s;
        s.contributing = Words<N>{};
        for (std::uint32_t k = 0; k < block_height; ++k) {
            s.t[k] = load<N>(block.transmittance[k] + column);
            s.r[k] = load<N>(block.red[k] + column);
            s.g[k] = load<N>(block.green[k] + column);
            s.b[k] = load<N>(block.blue[k] + column);
            if constexpr (AnyBlock::has_depth) s.w[k] = load<N>(block.weight[k] + column), s.z[k] = load<N>(block.depth[k] + column);
        }
        blend_hits<Rule, Stop, N>(s, c, hits, n, at, column, m, limits);
        for (std::uint32_t k = 0; k < block_height; ++k) {
            store(block.transmittance[k] + column, s.t[k]);
            store(block.red[k] + column, s.r[k]);
            store(block.green[k] + column, s.g[k]);
            store(block.blue[k] + column, s.b[k]);
            if constexpr (AnyBlock::has_depth) store(block.weight[k] + column, s.w[k]), store(block.depth[k] + column, s.z[k]);
        }
        std::uint32_t counts[N];
        store(counts, s.contributing);
        for (std::uint32_t count : counts) contributing += count;
    }
    return contributing;
}

/// How many of the next `most` splats are evaluated as the first one is.
inline std::uint32_t same_rule(std::uint32_t const* hits, std::uint32_t most) noexcept
{
    std::uint32_t n = 1;
    while (n < most && ((hits[n] ^ hits[0]) & Hit::recurs) == 0) ++n;
    return n;
}

inline bool finished(Block const& block, float transmittance_min) noexcept
{
    std::uint32_t going = 0;
    for (auto const& row : block.transmittance)
        for (float t : row) going |= t >= transmittance_min ? 1u : 0u;
    return going == 0;
}
template <class AnyBlock>
Blended blended(AnyBlock const& block, std::uint32_t row, std::uint32_t column) noexcept
{
    Blended b{{block.red[row][column], block.green[row][column], block.blue[row][column]}, block.transmittance[row][column], 0, 0};
    if constexpr (AnyBlock::has_depth) {
        b.weight = block.weight[row][column];
        b.depth = block.depth[row][column];
    }
    return b;
}

/// A block that is open: where it is, what it holds, and whether all its pixels have stopped.
template <bool HasDepth>
struct OpenBlock {
    BlockPlace at;
    std::conditional_t<HasDepth, DepthBlock, Block> state;
    PixelRect live;           ///< its pixels within the tile
    std::uint32_t number;     ///< in the tile, row by row
    std::uint32_t blended;    ///< splats so far
    bool done;

    void begin(std::uint32_t bx, std::uint32_t by, std::uint32_t index, PixelRect const& tile, Camera const& camera) noexcept
    {
        at.column = static_cast<std::int32_t>(bx);
        at.row = static_cast<std::int32_t>(by);
        for (std::uint32_t i = 0; i < block_width; ++i) at.xs[i] = static_cast<float>(bx + i) + 0.5f - camera.cx;
        for (std::uint32_t j = 0; j < block_height; ++j) at.ys[j] = static_cast<float>(by + j) + 0.5f - camera.cy;
        live = {bx > tile.x0 ? bx : tile.x0, bx + block_width < tile.x1 ? bx + block_width : tile.x1,
                by > tile.y0 ? by : tile.y0, by + block_height < tile.y1 ? by + block_height : tile.y1};
        state = {};
        bool const whole = live.x1 - live.x0 == block_width && live.y1 - live.y0 == block_height;
        for (std::uint32_t j = 0; j < block_height; ++j)
            for (std::uint32_t i = 0; i < block_width; ++i) state.transmittance[j][i] = 1.0f;
        for (std::uint32_t j = 0; j < block_height && !whole; ++j)
            for (std::uint32_t i = 0; i < block_width; ++i)
                if (!(bx + i >= live.x0 && bx + i < live.x1 && by + j >= live.y0 && by + j < live.y1))
                    state.transmittance[j][i] = -1.0f;
        number = index;
        blended = 0;
        done = false;
    }
};

/// Splats that a block blends before it looks whether all its pixels have stopped: early enough for walls of opaque splats
/// (numerics, row 55), and rare enough to cost nothing.
inline constexpr std::uint32_t blended_between_looks = 64;

/// Tells the host's caches that a splat is read soon: where records are scattered, waiting for them takes 7 % of a frame.
inline void fetch_ahead(Splat const& s) noexcept
{
    __builtin_prefetch(&s);
    __builtin_prefetch(reinterpret_cast<char const*>(&s) + sizeof(Splat) - 1);
}

/// The same for pixels [x0, x1) that are written soon.
template <class Pixel>
void fetch_row_ahead(Pixel* row, std::uint32_t x0, std::uint32_t x1) noexcept
{
    constexpr std::uint32_t line_px = sizeof(Pixel) < 64 ? 64 / sizeof(Pixel) : 1; // a cache line, rounded down
    for (std::uint32_t x = x0; x < x1; x += line_px) __builtin_prefetch(row + x, 1);
    __builtin_prefetch(row + (x1 - 1), 1);
}

/// `blend_tile` by one arithmetic, `Group` blocks at a time; `counts[number % workers]` gets the pairs of block `number`.
template <class Rule, class Stop, std::uint32_t N, std::uint32_t Group, std::uint32_t Size, class Pixel, class SplatAt>
void blend_tile_by(PixelRect const& tile, Camera const& camera, Model const& model, std::uint32_t n, SplatAt const& at,
                   Pixel* pixels, std::uint32_t stride_px, Worker worker, PairCount* counts, std::uint32_t workers) noexcept
{
    static_assert(!Stop::drops_crossing || !Pixel::has_alpha, "StopBeforeCrossing turns the sign of what a pixel keeps (an alpha would be "
                                                              "above 1); blend pixels without alpha");
    RowLimits const limits{model.alpha_min};
    OpenBlock<Pixel::has_depth> group[Group];
    Chunk<Size> chunk;
    std::uint32_t hits[Size + 1]; // a refused splat is written behind the last hit
    std::uint32_t const left = tile.x0 / block_width * block_width;
    std::uint32_t const across = (tile.x1 - left + block_width - 1) / block_width;
    std::uint32_t const top = tile.y0 / block_height * block_height;
    std::uint32_t const blocks = across * ((tile.y1 - top + block_height - 1) / block_height);

    constexpr std::uint32_t fetched = 12;
    for (std::uint32_t next = worker.index; next < blocks;) {
        for (std::uint32_t i = 0; i < n && i < fetched; ++i) fetch_ahead(at(i));
        std::uint32_t open = 0;
        for (; open < Group && next < blocks; ++open, next += worker.count)
            group[open].begin(left + next % across * block_width, top + next / across * block_height, next, tile, camera);
        for (std::uint32_t b = 0; b < open; ++b)
            for (std::uint32_t y = group[b].live.y0; y < group[b].live.y1; ++y)
                fetch_row_ahead(pixels + (y - tile.y0) * stride_px, group[b].live.x0 - tile.x0, group[b].live.x1 - tile.x0);
        std::uint32_t going = open;
        for (std::uint32_t begin = 0; begin < n && going != 0; begin += Size) {
            std::uint32_t const most = n - begin < Size ? n - begin : Size;
            for (std::uint32_t i = 0; i < most; ++i) {
                fetch_ahead(at(begin + i + fetched < n ? begin + i + fetched : n - 1));
                chunk.take(i, at(begin + i));
            }
            for (std::uint32_t i = most; i < (most + N - 1) / N * N; ++i) chunk.take(i, at(begin)); // whole lanes, not listed
            chunk.template complete<Rule, N>(most);
            for (std::uint32_t b = 0; b < open; ++b) {
                auto& block = group[b];
                if (block.done) continue;
                std::uint32_t const count = list_hits<Rule, N>(chunk, most, block.at, model.alpha_max, hits);
                auto& pairs = counts[block.number % workers];
                for (std::uint32_t done = 0; done < count && !block.done;) {
                    std::uint32_t part = blended_between_looks - block.blended % blended_between_looks;
                    if (part > count - done) part = count - done;
                    std::uint32_t const* const run = hits + done;
                    if constexpr (Rule::recurs) part = same_rule(run, part);
                    if (Rule::recurs && (run[0] & Hit::recurs) != 0)
                        pairs.contributing += blend_block<Rule, Stop, N>(block.state, chunk, run, part, block.at, model, limits);
                    else
                        pairs.contributing += blend_block<EachPair, Stop, N>(block.state, chunk, run, part, block.at, model, limits);
                    pairs.blocks += part;
                    done += part;
                    block.blended += part;
                    if (block.blended % blended_between_looks == 0 && finished(block.state, model.transmittance_min))
                        block.done = true, --going;
                }
            }
        }
        for (std::uint32_t b = 0; b < open; ++b) {
            auto const& block = group[b];
            auto const& live = block.live;
            std::uint32_t const skip = live.x0 - static_cast<std::uint32_t>(block.at.column);
            for (std::uint32_t y = live.y0; y < live.y1; ++y) {
                std::uint32_t const row = y - static_cast<std::uint32_t>(block.at.row);
                Pixel* const to = pixels + (y - tile.y0) * stride_px + (live.x0 - tile.x0);
                if (live.x1 - live.x0 == block_width) { // nearly always: a loop of constant length
                    for (std::uint32_t i = 0; i < block_width; ++i) to[i] = Pixel::make(blended(block.state, row, i));
                } else {
                    for (std::uint32_t i = 0; i < live.x1 - live.x0; ++i)
                        to[i] = Pixel::make(blended(block.state, row, skip + i));
                }
            }
        }
    }
}

/// `blend_tile_by` the arithmetic that the model asks for.
template <std::uint32_t N, std::uint32_t Group, std::uint32_t Size, class Pixel, class SplatAt>
void blend_tile_as_asked(PixelRect const& tile, Camera const& camera, Model const& model, std::uint32_t n, SplatAt const& at,
                         Pixel* pixels, std::uint32_t stride_px, Worker worker, PairCount* counts, std::uint32_t workers) noexcept
{
    if (tile.empty()) return;
    if (model.arithmetic == Arithmetic::precise || !(model.alpha_min >= faintest_cut))
        blend_tile_by<EachPair, StopEachPixel, N, Group, Size>(tile, camera, model, n, at, pixels, stride_px, worker, counts, workers);
    else
        blend_tile_by<FastRule, StopEachPixel, N, Group, Size>(tile, camera, model, n, at, pixels, stride_px, worker, counts, workers);
}
} // namespace detail

/// Blends n splats, `at(0)` to `at(n - 1)` from front to back, into the pixels of `tile`: blend then stop, C += w c and T -= w
/// with w = alpha T, until T < transmittance_min. Pixel (x, y) is `pixels[(y - tile.y0) * stride_px + x - tile.x0]`.
///
/// `precise` arithmetic is bit-identical to the naive per-pixel loop over the whole frame, for any tiling and any `Lanes`.
/// `fast` differs from it by at most 2e-5 of alpha (tests/splat/blending.cpp) and is bit-identical to itself over tilings and
/// lanes. `worker` takes every count-th block, so that workers write disjoint pixels.
///
/// Cost: 80 pairs for each splat that a block may see before all of its pixels have stopped; about 3.5 KiB of stack.
template <std::uint32_t Lanes = detail::native_lanes, class Pixel, class SplatAt>
PairCount blend_tile(PixelRect const& tile, Camera const& camera, Model const& model, std::uint32_t n, SplatAt const& at,
                     Pixel* pixels, std::uint32_t stride_px, Worker worker) noexcept
{
    PairCount pairs{};
    detail::blend_tile_as_asked<Lanes, 1, 16>(tile, camera, model, n, at, pixels, stride_px, worker, &pairs, 1);
    return pairs;
}

/// The same by one host thread for all of a tile's workers: `counts[w]` gets what worker w of `workers` would have counted.
/// It passes over the splats once for 8 blocks, a whole tile of the paper's. Cost: 22 KiB of stack.
template <std::uint32_t Lanes = detail::native_lanes, class Pixel, class SplatAt>
void blend_whole_tile(PixelRect const& tile, Camera const& camera, Model const& model, std::uint32_t n, SplatAt const& at,
                      Pixel* pixels, std::uint32_t stride_px, PairCount* counts, std::uint32_t workers) noexcept
{
    detail::blend_tile_as_asked<Lanes, 8, 128>(tile, camera, model, n, at, pixels, stride_px, Worker{0, 1}, counts, workers);
}

/// What Composite blends with; a setup may name another (`S::Blending`): `tile` for one worker's share, `whole` for all shares by
/// one host thread. `frame` is what the tiles were told.
struct BlendAsAsked {
    template <class Frame, class SplatAt, class Pixel>
    TILEMESH_KERNEL static PairCount tile(PixelRect const& tile, Frame const& frame, std::uint32_t n, SplatAt const& at, Pixel* pixels,
                          std::uint32_t stride_px, Worker worker) noexcept
    {
        return blend_tile(tile, frame.view.camera, frame.view.model, n, at, pixels, stride_px, worker);
    }
    template <class Frame, class SplatAt, class Pixel>
    TILEMESH_KERNEL static void whole(PixelRect const& tile, Frame const& frame, std::uint32_t n, SplatAt const& at, Pixel* pixels,
                      std::uint32_t stride_px, PairCount* counts, std::uint32_t workers) noexcept
    {
        blend_whole_tile(tile, frame.view.camera, frame.view.model, n, at, pixels, stride_px, counts, workers);
    }
};

} // namespace tilemesh::splat
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
