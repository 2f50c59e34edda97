#pragma once
#include <cstddef>
#include <tilemesh/splat/blending_rules.hpp>
#include <tilemesh/splat/policies.hpp>

/// Finds the splats that a pixel of a block may see. It tests as many splats at once as a vector has lanes.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::detail {

/// A chunk of splats: one array per field.
template <std::uint32_t Size>
struct alignas(vector_bytes) Chunk {
    static constexpr std::uint32_t size = Size;
    float mean_x[size], mean_y[size];
    float along[size], slope[size], across[size], opacity[size];
    float red[size], green[size], blue[size];
    std::uint32_t depth_key[size];
    float faintest[size];
    float steepest[size]; ///< across slope / (along + across slope^2): times y, the x of the best point on a horizontal edge
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
        depth_key[i] = s.depth_key;
        faintest[i] = s.faintest;
        x0[i] = static_cast<std::int32_t>(s.columns & 0xffffu);
        x1[i] = static_cast<std::int32_t>(s.columns >> 16);
        y0[i] = static_cast<std::int32_t>(s.rows & 0xffffu);
        y1[i] = static_cast<std::int32_t>(s.rows >> 16);
    }
    /// `take` for four splats.
    void take_four(std::uint32_t i, Splat const& s, Splat const& t, Splat const& u, Splat const& v) noexcept
    {
        static_assert(offsetof(Splat, mean_px) == 0 && offsetof(Splat, along) == 8 && offsetof(Splat, slope) == 12);
        static_assert(offsetof(Splat, across) == 16 && offsetof(Splat, opacity) == 20 && offsetof(Splat, colour) == 24);
        static_assert(offsetof(Splat, depth_key) == 36 && offsetof(Splat, faintest) == 40 && offsetof(Splat, columns) == 44);
        auto const words = [](Splat const& from, std::uint32_t first) noexcept {
            Floats<4> w;
            std::memcpy(&w, reinterpret_cast<char const*>(&from) + first * sizeof(float), sizeof w);
            return w;
        };
        float packed[4];
        store_transposed(words(s, 0), words(t, 0), words(u, 0), words(v, 0), mean_x + i, mean_y + i, along + i, slope + i);
        store_transposed(words(s, 4), words(t, 4), words(u, 4), words(v, 4), across + i, opacity + i, red + i, green + i);
        store_transposed(words(s, 8), words(t, 8), words(u, 8), words(v, 8), blue + i, reinterpret_cast<float*>(depth_key + i), faintest + i, packed);
        Words<4> const columns = bits_of<4>(load<4>(packed));
        Words<4> const rows = __builtin_bit_cast(Words<4>, UnsignedWords<4>{s.rows, t.rows, u.rows, v.rows});
        store(x0 + i, Words<4>(columns & 0xffff));
        store(x1 + i, Words<4>(columns >> 16 & 0xffff));
        store(y0 + i, Words<4>(rows & 0xffff));
        store(y1 + i, Words<4>(rows >> 16 & 0xffff));
    }
    /// Computes the fields that follow from others, for the first n splats and for the splats that fill their last lanes.
    template <std::uint32_t N>
    TILEMESH_KERNEL void complete(std::uint32_t n) noexcept
    {
        for (std::uint32_t i = 0; i < n; i += N) {
            Floats<N> const k = load<N>(slope + i), steep = load<N>(across + i) * k;
            store(steepest + i, Floats<N>(steep / (load<N>(along + i) + steep * k)));
        }
    }
};

template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> clamped(Floats<N> const& v, Floats<N> const& low, Floats<N> const& high) noexcept
{
    return v < low ? low : v > high ? high : v;
}
/// The distance of v and w beyond the rounding error of two such numbers (2^-21 of them: 8 roundings); 0 for NaN. For a needle whose mean
/// is far from the frame, v - w may be nothing but rounding error.
template <std::uint32_t N>
TILEMESH_KERNEL Floats<N> beyond_rounding(Floats<N> const& v, Floats<N> const& w) noexcept
{
    Floats<N> const rounding = 0x1p-21f * (magnitude<N>(v) + magnitude<N>(w)), distance = magnitude<N>(v - w);
    return distance > rounding ? distance - rounding : Floats<N>{};
}

/// The fields of splats that decide which blocks they reach, in lanes.
template <std::uint32_t N>
struct Form {
    Floats<N> along, slope, across, steepest, faintest;
};

/// May a pixel of a block see these splats? The test computes the largest power over the block's pixel centres. The power is largest at the
/// point of the block that is nearest to the mean in the splat's own metric. A false yes is harmless. A false no cannot occur: the margin
/// (2 % of alpha and 1e-4 of the power) is far larger than the rounding on both sides. (x0, x1, y0, y1): the block's outermost pixel
/// centres relative to the means.
template <std::uint32_t N>
TILEMESH_KERNEL Words<N> reaches(Form<N> const& s, Floats<N> const& x0, Floats<N> const& x1, Floats<N> const& y0,
                                 Floats<N> const& y1) noexcept
{
    // The best point of the vertical edge and of the horizontal edge, on the side of the block that faces the mean.
    auto const x = clamped<N>(Floats<N>{}, x0, x1), y = clamped<N>(Floats<N>{}, y0, y1);
    auto const best_y = clamped<N>(s.slope * x, y0, y1);
    auto const off1 = beyond_rounding<N>(best_y, s.slope * x);
    auto const power1 = s.along * x * x + s.across * off1 * off1;
    auto const best_x = clamped<N>(s.steepest * y, x0, x1);
    auto const off2 = beyond_rounding<N>(y, s.slope * best_x);
    auto const power2 = s.along * best_x * best_x + s.across * off2 * off2;
    auto const power = power1 > power2 ? power1 : power2;
    return ~(power * (1.0f - 1e-4f) + 0.02f < s.faintest); // NaN says yes
}
template <std::uint32_t N, std::uint32_t Size>
TILEMESH_KERNEL Words<N> reaches(Chunk<Size> const& c, std::uint32_t i, Floats<N> const& x0, Floats<N> const& x1,
                                 Floats<N> const& y0, Floats<N> const& y1) noexcept
{
    return reaches<N>(Form<N>{load<N>(c.along + i), load<N>(c.slope + i), load<N>(c.across + i), load<N>(c.steepest + i),
                              load<N>(c.faintest + i)},
                      x0, x1, y0, y1);
}

/// The rows of a block that a splat covers, for each range [first, last) of rows: all bits of a covered row are set, none of the others.
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

/// The least alpha of each row, for each range of CoveredRows: alpha_min in the rows that a splat covers, infinity in the others.
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

/// The inputs of a block, apart from its state and its splats.
struct alignas(vector_bytes) BlockPlace {
    float xs[block_width];              ///< pixel centres relative to the principal point
    float ys[block_height];
    std::int32_t column, row;           ///< position of the block's first pixel
};

/// A splat that a block blends, as one word: its number in the chunk, a bit for each strip of columns that its rectangle touches, and the
/// number of its RowLimits.
struct Hit {
    static constexpr std::uint32_t number = 0xffu, strips_at = 9, limits_at = 26;
};
static_assert(Hit::strips_at + block_width <= Hit::limits_at && CoveredRows::patterns <= 1u << (32 - Hit::limits_at), "a hit is one word");

/// The bits of the strips, N columns each, that the columns [x0, x1) of splats touch.
template <std::uint32_t N>
TILEMESH_KERNEL Words<N> touched_strips(Words<N> const& x0, Words<N> const& x1) noexcept
{
    Words<N> bits{};
    for (std::uint32_t strip = 0; strip < block_width / N; ++strip) {
        auto const begin = static_cast<std::int32_t>(strip * N), end = begin + static_cast<std::int32_t>(N);
        bits |= (x0 < end) & (x1 > begin) & static_cast<std::int32_t>(1u << (Hit::strips_at + strip));
    }
    return bits;
}

/// Completes a chunk (`Chunk::complete`) with a set of instructions.
struct CompleteChunk {
    template <class Set, std::uint32_t Size>
    TILEMESH_KERNEL static void run(Chunk<Size>& chunk, std::uint32_t n) noexcept
    {
        chunk.template complete<Set::most_lanes>(n);
    }
};

/// Lists the splats of a chunk that a pixel of the block may see, and returns their number. `hits` must have room for Set::most_lanes more
/// than n.
struct ListHits {
    template <class Set, std::uint32_t Size>
    TILEMESH_KERNEL static std::uint32_t run(Chunk<Size> const& c, std::uint32_t n, BlockPlace const& at, std::uint32_t* hits) noexcept
    {
        constexpr std::uint32_t N = Set::most_lanes;
        constexpr std::int32_t rows = static_cast<std::int32_t>(block_height);
        [[maybe_unused]] std::int32_t entries[Set::compresses ? Size : 1], listed[Set::compresses ? Size : 1];
        Words<N> number = counted_lanes<N>();
        std::uint32_t count = 0;
        for (std::uint32_t i = 0; i < n; i += N, number += static_cast<std::int32_t>(N)) {
            auto const mean_x = load<N>(c.mean_x + i), mean_y = load<N>(c.mean_y + i);
            Floats<N> const x0 = at.xs[0] - mean_x, x1 = at.xs[block_width - 1] - mean_x;
            Floats<N> const y0 = at.ys[0] - mean_y, y1 = at.ys[block_height - 1] - mean_y;
            Words<N> first = load_words<N>(c.y0 + i) - at.row, last = load_words<N>(c.y1 + i) - at.row;
            Words<N> const from = load_words<N>(c.x0 + i) - at.column, to = load_words<N>(c.x1 + i) - at.column;
            Words<N> const seen = reaches<N>(c, i, x0, x1, y0, y1) & (first < rows) & (last > 0) &
                                  (from < static_cast<std::int32_t>(block_width)) & (to > 0) & (number < static_cast<std::int32_t>(n));
            first = first > 0 ? first : Words<N>{};
            last = last < rows ? last : broadcast_word<N>(rows);
            Words<N> entry = number | (first * (rows + 1) + last) << static_cast<std::int32_t>(Hit::limits_at);
            if constexpr (N < block_width) entry |= touched_strips<N>(from, to);
            if constexpr (Set::compresses) {
                store(entries + i, entry);
                store(listed + i, seen);
            } else {
                count += store_compressed<N>(hits + count, entry, seen);
            }
        }
        if constexpr (Set::compresses) count = Set::compress(hits, entries, listed, n);
        return count;
    }
};

}}} // namespace tilemesh::splat::detail
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
