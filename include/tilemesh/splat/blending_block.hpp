#pragma once
#include <cmath>
#include <tilemesh/splat/blending_hits.hpp>
#include <tilemesh/splat/exponential.hpp>
#include <type_traits>

/// Blends the splats that a block may see, one after the other, into the rows of the block.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::detail {

/// The state of a block, row by row. Lanes outside the tile are dead: their transmittance is negative.
struct BlockFields {
    float transmittance[block_height][block_width];
    float red[block_height][block_width];
    float green[block_height][block_width];
    float blue[block_height][block_width];
    static constexpr bool has_depth = false;
};
struct DepthBlockFields : BlockFields {
    float weight[block_height][block_width];
    float depth[block_height][block_width];
    static constexpr bool has_depth = true;
};
/// The same on vector bounds, for a block that is blended at once.
struct alignas(vector_bytes) Block : BlockFields {};
struct alignas(vector_bytes) DepthBlock : DepthBlockFields {};

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

/// Blends one row: C += w c and T -= w with w = alpha T, in the lanes that take part. A lane that takes no part adds 0, which changes no
/// bit.
template <class Stop, std::uint32_t K, std::uint32_t N, bool HasDepth>
TILEMESH_KERNEL void blend_row(Strip<N, HasDepth>& s, Floats<N> const& alpha, Rules const& m, float const* least,
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
#if defined(__wasm__) // a select takes three operations more there
    Floats<N> const share_of_lane = alpha * s.t[K];
    Floats<N> const weight = floats_of<N>(bits_of<N>(share_of_lane) & takes_part);
#else
    Floats<N> const weight = takes_part ? alpha * s.t[K] : Floats<N>{};
#endif
    s.r[K] = multiply_add_lanes<N>(weight, c.r, s.r[K]);
    s.g[K] = multiply_add_lanes<N>(weight, c.g, s.g[K]);
    s.b[K] = multiply_add_lanes<N>(weight, c.b, s.b[K]);
    s.t[K] = s.t[K] - weight;
    if constexpr (HasDepth) {
        s.w[K] = s.w[K] + weight;
        s.z[K] = multiply_add_lanes<N>(weight, c.z, s.z[K]);
    }
#if defined(__wasm__)
    s.contributing -= takes_part; // all bits set are -1
#else
    s.contributing = takes_part ? s.contributing + 1 : s.contributing;
#endif
}

/// alpha of row K, computed as in the naive loop. `lowest`: lowest_power_for(alpha_min).
template <std::uint32_t K, std::uint32_t N, std::uint32_t Size>
TILEMESH_KERNEL Floats<N> alpha_of_row(Chunk<Size> const& c, std::uint32_t i, BlockPlace const& at, Floats<N> const& dx,
                                       Floats<N> const& opacity, float alpha_max, float lowest) noexcept
{
    Floats<N> const dy = broadcast<N>(at.ys[K] - c.mean_y[i]);
    Floats<N> const off = multiply_add_lanes<N>(broadcast<N>(-c.slope[i]), dx, dy);
    Floats<N> const power = multiply_add_lanes<N>(c.along[i] * dx, dx, c.across[i] * off * off);
    Floats<N> const alpha = opacity * exponential_lanes<N>(power, lowest);
    return alpha < alpha_max ? alpha : broadcast<N>(alpha_max);
}

template <bool HasDepth, std::uint32_t N, std::uint32_t Size>
TILEMESH_KERNEL LaneColour<N> colour_of(Chunk<Size> const& c, std::uint32_t i) noexcept
{
    LaneColour<N> l{broadcast<N>(c.red[i]), broadcast<N>(c.green[i]), broadcast<N>(c.blue[i]), Floats<N>{}};
    if constexpr (HasDepth) l.z = broadcast<N>(depth_of_key(c.depth_key[i]));
    return l;
}
/// The opacity. It is -1 in columns outside the splat's rectangle, so that alpha is below every cut-off there.
template <std::uint32_t N, std::uint32_t Size>
TILEMESH_KERNEL Floats<N> opacity_of(Chunk<Size> const& c, std::uint32_t i, Words<N> const& columns) noexcept
{
    auto const offset = __builtin_bit_cast(UnsignedWords<N>, Words<N>(columns - c.x0[i]));
    return offset < static_cast<std::uint32_t>(c.x1[i] - c.x0[i]) ? broadcast<N>(c.opacity[i]) : broadcast<N>(-1.0f);
}

/// alpha in all rows of a block.
template <std::uint32_t N>
struct AllRows {
    Floats<N> alpha[block_height];
};

/// Blends the splats of `hits` into N columns.
template <class Stop, std::uint32_t N, bool HasDepth, std::uint32_t Size>
TILEMESH_KERNEL void blend_hits(Strip<N, HasDepth>& s, Chunk<Size> const& c, std::uint32_t const* hits, std::uint32_t n,
                                BlockPlace const& at, std::uint32_t column, Rules const& m, RowLimits const& limits) noexcept
{
    static_assert(block_height == 5, "the rows below are written out: a loop would leave the registers");
    auto const xs = load<N>(at.xs + column);
    Words<N> const columns = counted_lanes<N>() + (at.column + static_cast<std::int32_t>(column));
    float const lowest = lowest_power_for(m.alpha_min);
    for (std::uint32_t h = 0; h < n; ++h) {
        std::uint32_t const i = hits[h] & Hit::number;
        auto const l = colour_of<HasDepth, N>(c, i);
        float const* const least = limits.of(hits[h] >> Hit::limits_at);
        Floats<N> const dx = xs - c.mean_x[i], opacity = opacity_of<N>(c, i, columns);
        blend_row<Stop, 0, N>(s, alpha_of_row<0, N>(c, i, at, dx, opacity, m.alpha_max, lowest), m, least, l);
        blend_row<Stop, 1, N>(s, alpha_of_row<1, N>(c, i, at, dx, opacity, m.alpha_max, lowest), m, least, l);
        blend_row<Stop, 2, N>(s, alpha_of_row<2, N>(c, i, at, dx, opacity, m.alpha_max, lowest), m, least, l);
        blend_row<Stop, 3, N>(s, alpha_of_row<3, N>(c, i, at, dx, opacity, m.alpha_max, lowest), m, least, l);
        blend_row<Stop, 4, N>(s, alpha_of_row<4, N>(c, i, at, dx, opacity, m.alpha_max, lowest), m, least, l);
    }
}

/// Rows [First, Last) of a strip: blends the splats `hits[listed[0]]` to `hits[listed[n - 1]]`, whose alphas are known.
template <class Stop, std::uint32_t First, std::uint32_t Last, std::uint32_t N, class AnyBlock, std::uint32_t Size>
TILEMESH_KERNEL void blend_known_rows(AnyBlock& block, Chunk<Size> const& c, std::uint32_t const* hits, AllRows<N> const* alphas,
                                      std::uint32_t const* listed, std::uint32_t n, std::uint32_t column, Rules const& m,
                                      RowLimits const& limits, Words<N>& contributing) noexcept
{
    static_assert(Last - First == 1 || Last - First == 2, "the rows below are written out");
    constexpr std::uint32_t A = First, B = Last - 1;
    Strip<N, AnyBlock::has_depth> s;
    s.contributing = contributing;
    for (std::uint32_t k = A; k <= B; ++k) {
        s.t[k] = load<N>(block.transmittance[k] + column);
        s.r[k] = load<N>(block.red[k] + column);
        s.g[k] = load<N>(block.green[k] + column);
        s.b[k] = load<N>(block.blue[k] + column);
        if constexpr (AnyBlock::has_depth) s.w[k] = load<N>(block.weight[k] + column), s.z[k] = load<N>(block.depth[k] + column);
    }
    for (std::uint32_t i = 0; i < n; ++i) {
        std::uint32_t const h = listed[i];
        auto const& alpha = alphas[h].alpha;
        auto const l = colour_of<AnyBlock::has_depth, N>(c, hits[h] & Hit::number);
        float const* const least = limits.of(hits[h] >> Hit::limits_at);
        blend_row<Stop, A, N>(s, alpha[A], m, least, l);
        if constexpr (A != B) blend_row<Stop, B, N>(s, alpha[B], m, least, l);
    }
    for (std::uint32_t k = A; k <= B; ++k) {
        store(block.transmittance[k] + column, s.t[k]);
        store(block.red[k] + column, s.r[k]);
        store(block.green[k] + column, s.g[k]);
        store(block.blue[k] + column, s.b[k]);
        if constexpr (AnyBlock::has_depth) store(block.weight[k] + column, s.w[k]), store(block.depth[k] + column, s.z[k]);
    }
    contributing = s.contributing;
}
/// `blend_columns`, with the same bits, for a target with few registers: first the alphas of all splats, then the rows, two at a time. A
/// splat whose alpha is below the cut in all pixels of the two rows adds nothing to them, so leaving it out there changes no bit.
template <class Stop, std::uint32_t N, class AnyBlock, std::uint32_t Size>
TILEMESH_KERNEL void blend_columns_by_rows(AnyBlock& block, Chunk<Size> const& c, std::uint32_t const* hits, std::uint32_t n,
                                           BlockPlace const& at, std::uint32_t column, Rules const& m, RowLimits const& limits,
                                           std::uint32_t (&contributing)[N]) noexcept
{
    static_assert(block_height == 5, "the groups of rows are written out");
    auto const xs = load<N>(at.xs + column);
    Words<N> const columns = counted_lanes<N>() + (at.column + static_cast<std::int32_t>(column));
    float const lowest = lowest_power_for(m.alpha_min);
    AllRows<N> alphas[blended_between_looks];
    std::uint32_t listed[3][blended_between_looks], counts[3] = {};
    for (std::uint32_t h = 0; h < n; ++h) {
        auto& alpha = alphas[h].alpha;
        std::uint32_t const number = hits[h] & Hit::number;
        Floats<N> const dx = xs - c.mean_x[number], opacity = opacity_of<N>(c, number, columns);
        alpha[0] = alpha_of_row<0, N>(c, number, at, dx, opacity, m.alpha_max, lowest);
        alpha[1] = alpha_of_row<1, N>(c, number, at, dx, opacity, m.alpha_max, lowest);
        alpha[2] = alpha_of_row<2, N>(c, number, at, dx, opacity, m.alpha_max, lowest);
        alpha[3] = alpha_of_row<3, N>(c, number, at, dx, opacity, m.alpha_max, lowest);
        alpha[4] = alpha_of_row<4, N>(c, number, at, dx, opacity, m.alpha_max, lowest);
        float const* const least = limits.of(hits[h] >> Hit::limits_at);
        for (std::uint32_t group = 0; group < 3; ++group) listed[group][counts[group]] = h; // no branch: a predictor cannot know the splats
        counts[0] += any_lane<N>((alpha[0] >= least[0]) | (alpha[1] >= least[1]));
        counts[1] += any_lane<N>((alpha[2] >= least[2]) | (alpha[3] >= least[3]));
        counts[2] += any_lane<N>(alpha[4] >= least[4]);
    }
    Words<N> contributed{};
    blend_known_rows<Stop, 0, 2, N>(block, c, hits, alphas, listed[0], counts[0], column, m, limits, contributed);
    blend_known_rows<Stop, 2, 4, N>(block, c, hits, alphas, listed[1], counts[1], column, m, limits, contributed);
    blend_known_rows<Stop, 4, 5, N>(block, c, hits, alphas, listed[2], counts[2], column, m, limits, contributed);
    store(contributing, contributed);
}

/// Blends the splats of `hits` into N columns of a block. `contributing[i]`: the pairs of column i that contributed.
template <class Stop, std::uint32_t N, class AnyBlock, std::uint32_t Size>
TILEMESH_KERNEL void blend_columns(AnyBlock& block, Chunk<Size> const& c, std::uint32_t const* hits, std::uint32_t n, BlockPlace const& at,
                                   std::uint32_t column, Rules const& m, RowLimits const& limits, std::uint32_t (&contributing)[N]) noexcept
{
    Strip<N, AnyBlock::has_depth> s;
    s.contributing = Words<N>{};
    for (std::uint32_t k = 0; k < block_height; ++k) {
        s.t[k] = load<N>(block.transmittance[k] + column);
        s.r[k] = load<N>(block.red[k] + column);
        s.g[k] = load<N>(block.green[k] + column);
        s.b[k] = load<N>(block.blue[k] + column);
        if constexpr (AnyBlock::has_depth) s.w[k] = load<N>(block.weight[k] + column), s.z[k] = load<N>(block.depth[k] + column);
    }
    blend_hits<Stop, N>(s, c, hits, n, at, column, m, limits);
    for (std::uint32_t k = 0; k < block_height; ++k) {
        store(block.transmittance[k] + column, s.t[k]);
        store(block.red[k] + column, s.r[k]);
        store(block.green[k] + column, s.g[k]);
        store(block.blue[k] + column, s.b[k]);
        if constexpr (AnyBlock::has_depth) store(block.weight[k] + column, s.w[k]), store(block.depth[k] + column, s.z[k]);
    }
    store(contributing, s.contributing);
}

/// The hits of a run that touch a strip, N columns of a block. A splat adds nothing to columns outside its rectangle, so leaving it out there
/// changes no bit.
template <std::uint32_t N>
struct StripHits {
    std::uint32_t count;
    std::uint32_t hits[blended_between_looks];
    StripHits(std::uint32_t const* run, std::uint32_t n, std::uint32_t column) noexcept
    {
        std::uint32_t listed = 0;
        for (std::uint32_t h = 0; h < n; ++h) { // no branch: a predictor cannot know the splats
            hits[listed] = run[h];
            listed += run[h] >> (Hit::strips_at + column / N) & 1u;
        }
        count = listed;
    }
};
template <>
struct StripHits<block_width> {
    std::uint32_t count;
    std::uint32_t const* hits;
    StripHits(std::uint32_t const* run, std::uint32_t n, std::uint32_t) noexcept : count(n), hits(run) {}
};

/// Blends the splats of `hits`, at most blended_between_looks, into a block. Returns the number of pairs that contributed. Each rule has its
/// own function, so that each can use all registers.
template <class Stop>
struct BlendBlock {
    template <class Set, class AnyBlock, std::uint32_t Size>
    TILEMESH_KERNEL static std::uint32_t run(AnyBlock& block, Chunk<Size> const& c, std::uint32_t const* hits, std::uint32_t n,
                                             BlockPlace const& at, Rules const& m, RowLimits const& limits) noexcept
    {
        // Keeps the stack frame on vector bounds. Otherwise Clang may let the vectors that it spills straddle two cache lines.
        [[maybe_unused]] alignas(vector_bytes) volatile std::uint32_t const on_bounds = 0;
        constexpr std::uint32_t N = Set::most_lanes;
        std::uint32_t contributing = 0;
        for (std::uint32_t column = 0; column < block_width; column += N) {
            StripHits<N> const strip(hits, n, column);
            if (strip.count == 0) continue;
            std::uint32_t counts[N];
            if constexpr (Set::blends_rows_apart)
                blend_columns_by_rows<Stop, N>(block, c, strip.hits, strip.count, at, column, m, limits, counts);
            else
                blend_columns<Stop, N>(block, c, strip.hits, strip.count, at, column, m, limits, counts);
            for (std::uint32_t one : counts) contributing += one;
        }
        return contributing;
    }
};

/// Fills a chunk with the splats from `begin` on, at most `Size` of n, and returns their number.
template <class Set, std::uint32_t Size, class SplatAt>
TILEMESH_KERNEL std::uint32_t fill(Set const& set, Chunk<Size>& chunk, std::uint32_t begin, std::uint32_t n, SplatAt const& at) noexcept
{
    std::uint32_t const most = n - begin < Size ? n - begin : Size, N = set.lanes();
    std::uint32_t i = 0;
    for (; Set::most_lanes >= 4 && i + 4 <= most; i += 4) chunk.take_four(i, at(begin + i), at(begin + i + 1), at(begin + i + 2), at(begin + i + 3));
    for (; i < most; ++i) chunk.take(i, at(begin + i));
    for (i = most; i < (most + N - 1) / N * N; ++i) chunk.take(i, at(begin)); // fills the lanes; not listed
    set.template call<CompleteChunk>(chunk, most);
    return most;
}

inline bool finished(BlockFields const& block, float transmittance_min) noexcept
{
    std::uint32_t going = 0;
    for (auto const& row : block.transmittance)
        for (float t : row) going |= t >= transmittance_min ? 1u : 0u;
    return going == 0;
}
/// Adds the background that shows through the pixels of a block.
inline void add_background(BlockFields& block, float const (&background)[3]) noexcept
{
    for (std::uint32_t j = 0; j < block_height; ++j)
        for (std::uint32_t i = 0; i < block_width; ++i) {
            float const through = std::fabs(block.transmittance[j][i]);
            block.red[j][i] = multiply_add(through, background[0], block.red[j][i]);
            block.green[j][i] = multiply_add(through, background[1], block.green[j][i]);
            block.blue[j][i] = multiply_add(through, background[2], block.blue[j][i]);
        }
}
template <class AnyBlock>
Blended blended(AnyBlock const& block, std::uint32_t row, std::uint32_t column) noexcept
{
    Blended b{{block.red[row][column], block.green[row][column], block.blue[row][column]}, std::fabs(block.transmittance[row][column]), 0, 0};
    if constexpr (AnyBlock::has_depth) {
        b.weight = block.weight[row][column];
        b.depth = block.depth[row][column];
    }
    return b;
}

/// The block that begins at pixel (x, y).
inline BlockPlace place_of(std::uint32_t x, std::uint32_t y, Camera const& camera) noexcept
{
    BlockPlace at;
    at.column = static_cast<std::int32_t>(x), at.row = static_cast<std::int32_t>(y);
    for (std::uint32_t i = 0; i < block_width; ++i) at.xs[i] = static_cast<float>(x + i) + 0.5f - camera.cx;
    for (std::uint32_t j = 0; j < block_height; ++j) at.ys[j] = static_cast<float>(y + j) + 0.5f - camera.cy;
    return at;
}

/// A block in progress: its place, its state, and whether all its pixels have stopped.
template <bool HasDepth>
struct OpenBlock {
    BlockPlace at;
    std::conditional_t<HasDepth, DepthBlock, Block> state;
    PixelRect live;           ///< the block's pixels that lie in the tile
    std::uint32_t number;     ///< number of the block in the tile, row by row
    std::uint32_t blended;    ///< splats blended so far
    bool done;

    void begin(std::uint32_t bx, std::uint32_t by, std::uint32_t index, PixelRect const& tile, Camera const& camera) noexcept
    {
        at = place_of(bx, by, camera);
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

}}} // namespace tilemesh::splat::detail
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
