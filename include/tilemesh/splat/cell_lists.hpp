#pragma once
#include <tilemesh/splat/cell_masks.hpp>
#include <tilemesh/splat/cell_state.hpp>
#include <tilemesh/splat/logarithm.hpp>
#include <tilemesh/splat/number.hpp>

/// Finds the cells that a splat reaches, and lists the splats of each cell. A splat reaches a cell if its ellipse at the cut does.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::detail {

/// The margins of the ellipse. `faintest` has 1 % of alpha; these are for its own rounding and for that of the recurrence.
inline constexpr float power_margin = 1.0001f, pixel_margin = 0.01f;
/// The distances of a needle's pixels consist of large terms. Their rounding, 2^-24 of the needle's half height, moves alpha by
/// sqrt(a) times as much; the limit is that of a = 2.4 and 512 pixels.
inline constexpr float longest_needle = 2.4f * 512 * 512;


/// The ellipses at the cut of L splats: |x - lean y| <= sqrt(f - e y^2), relative to the mean. Lengths along x are in cells.
template <std::uint32_t L>
struct Ellipses {
    using A = FloatLanes<L>;
    Floats<L> mean_y;
    Floats<L> from, to;      ///< the mean's column in cells, so that the integer parts of from - reach and to + reach are the first cell and the end
    Floats<L> lean, f, e;
    Floats<L> top, height;   ///< the row of the rightmost point, and half the height

    template <std::uint32_t Size>
    TILEMESH_KERNEL Ellipses(CellChunk<Size> const& c, std::uint32_t i) noexcept
        : mean_y(load<L>(c.mean_y + i)), from(load<L>(c.mean_x + i)), to(load<L>(c.right + i)), lean(load<L>(c.slope + i)),
          f(load<L>(c.along + i)), e(load<L>(c.across + i)), top(load<L>(c.opacity + i)), height(load<L>(c.faintest + i))
    {
    }
    /// Computes the ellipses of splats i to i + L - 1 of a chunk and stores them over the fields that they follow from: a worker's stack is
    /// small. Returns their bits of Special.
    template <std::uint32_t Size>
    TILEMESH_KERNEL static Words<L> complete(CellChunk<Size>& c, std::uint32_t i, Camera const& camera, float alpha_max) noexcept
    {
        constexpr float cell = 1.0f / static_cast<float>(cell_width);
        auto const least = broadcast<L>(-1e-30f); // so that nothing is 0 / 0
        Floats<L> const along = at_most<L>(load<L>(c.along + i), least), across = at_most<L>(load<L>(c.across + i), least);
        Floats<L> const slope = load<L>(c.slope + i), faintest = load<L>(c.faintest + i), mean_x = load<L>(c.mean_x + i);
        Floats<L> const steep = across * slope, per = 1.0f / (along + steep * slope);
        Floats<L> const f = faintest * per * (power_margin * cell * cell), e = (along * per) * (across * per) * (cell * cell);
        Floats<L> const reach = A::square_root(faintest / along), tall = f / e, half = A::square_root(tall);
        Floats<L> const x = mean_x + (camera.cx - 0.5f); // pixel centres are whole numbers
        Floats<L> const margin = pixel_margin + 0x1p-21f * (magnitude<L>(mean_x) + reach);
        Words<L> const special =
            apart(across * log2_e, tall) | clamped(load<L>(c.opacity + i), alpha_max) | clipped(c, i, x, faintest, reach, half, camera);
        put<L>(c.mean_x + i, (x + (1.0f - margin)) * cell);
        put<L>(c.right + i, (x + (static_cast<float>(cell_width) + margin)) * cell);
        put<L>(c.slope + i, steep * per * cell);
        put<L>(c.along + i, f);
        put<L>(c.across + i, e);
        put<L>(c.opacity + i, slope * reach);
        put<L>(c.faintest + i, half + pixel_margin);
        return special;
    }
    /// Bits [0, window.columns): the cells of the band whose first row has its centres at y.
    TILEMESH_KERNEL Words<L> band(float y, CellWindow const& window) const noexcept
    {
        std::uint32_t const column = window.column / cell_width;
        auto const least = broadcast<L>(static_cast<float>(column)), most = broadcast<L>(static_cast<float>(column + window.columns));
        Floats<L> const y0 = y - mean_y, y1 = y0 + static_cast<float>(cell_height - 1);
        Floats<L> const right_y = between<L>(top, y0, y1), left_y = between<L>(-top, y0, y1);
        Floats<L> const right = A::square_root(multiply_add_lanes<L>(-e * right_y, right_y, f));
        Floats<L> const left = A::square_root(multiply_add_lanes<L>(-e * left_y, left_y, f));
        // NaN, where the ellipse does not reach the band, becomes the first column.
        auto const end = A::truncate(between<L>(multiply_add_lanes<L>(lean, right_y, to) + right, least, most));
        auto const first = A::truncate(between<L>(multiply_add_lanes<L>(lean, left_y, from) - left, least, most));
        return between_bits(first - static_cast<std::int32_t>(column), end - static_cast<std::int32_t>(column)) & (y0 <= height) & (y1 >= -height);
    }
    /// Bits [first, end), none if end <= first; both are at most 8.
    TILEMESH_KERNEL static Words<L> between_bits(Words<L> const& first, Words<L> const& end) noexcept
    {
        Words<L> const bits = power(end) - power(first);
        return bits & (end > first);
    }

private:
    /// 2^n. Not every target has a shift by lanes.
    TILEMESH_KERNEL static Words<L> power(Words<L> const& n) noexcept
    {
#if defined(__AVX2__)
        return broadcast_word<L>(1) << n;
#else
        return A::truncate(floats_of<L>((n + 127) << 23));
#endif
    }
    TILEMESH_KERNEL static Words<L> apart(Floats<L> const& across2, Floats<L> const& tall) noexcept
    {
        Words<L> const in_reach = (across2 >= -sharpest) & (-across2 * tall <= longest_needle); // NaN says no
        return ~in_reach & static_cast<std::int32_t>(Special::apart);
    }
    TILEMESH_KERNEL static Words<L> clamped(Floats<L> const& opacity, float alpha_max) noexcept
    {
        return ~(opacity <= alpha_max * below_the_clamp) & static_cast<std::int32_t>(Special::clamped);
    }
    TILEMESH_KERNEL static Floats<L> margin(Floats<L> const& at, Floats<L> const& mean, Floats<L> const& half_side) noexcept
    {
        return 1e-4f + 1e-5f * half_side + 0x1p-21f * (magnitude<L>(at) + magnitude<L>(mean) + half_side);
    }
    /// May a pixel beyond the rectangle pass the cut? A tile beside the rectangle does not have the splat, so such a pixel must get nothing in
    /// any tiling. The opacity box touches the ellipse at the cut without margin; the test is of an ellipse that is larger by `margin`, in pixels:
    /// more than alpha's own error (2e-5 of it) and the rounding of x and reach move that ellipse. The frame's borders cut nothing.
    template <std::uint32_t Size>
    TILEMESH_KERNEL static Words<L> clipped(CellChunk<Size> const& c, std::uint32_t i, Floats<L> const& x, Floats<L> const& faintest,
                                            Floats<L> const& reach, Floats<L> const& half, Camera const& camera) noexcept
    {
        auto const share = A::square_root(at_least<L>((faintest + 0.01f) / faintest, Floats<L>{})); // of the ellipse at the cut
        Floats<L> const mean_y = load<L>(c.mean_y + i), y = mean_y + (camera.cy - 0.5f);
        Floats<L> const wide = reach * share + margin(x, load<L>(c.mean_x + i), reach), high = half * share + margin(y, mean_y, half);
        Words<L> const columns = loaded<L>(c.columns + i), rows = loaded<L>(c.rows + i);
        Words<L> const x0 = columns & 0xffff, x1 = columns >> 16 & 0xffff, y0 = rows & 0xffff, y1 = rows >> 16 & 0xffff;
        auto const width = static_cast<std::int32_t>(camera.width), depth = static_cast<std::int32_t>(camera.height);
        Words<L> const is = ((x0 > 0) & (A::real(x0 - 1) >= x - wide)) | ((x1 < width) & (A::real(x1) <= x + wide)) |
                            ((y0 > 0) & (A::real(y0 - 1) >= y - high)) | ((y1 < depth) & (A::real(y1) <= y + high));
        return is & static_cast<std::int32_t>(Special::clipped);
    }
};

/// The cells of a band that the rectangles of L splats touch.
template <std::uint32_t L>
struct Rectangles {
    Words<L> bits, y0, y1;
    template <std::uint32_t Size>
    TILEMESH_KERNEL Rectangles(CellChunk<Size> const& c, std::uint32_t i, CellWindow const& window) noexcept
    {
        constexpr std::int32_t width = static_cast<std::int32_t>(cell_width);
        auto const column = static_cast<std::int32_t>(window.column / cell_width), most = static_cast<std::int32_t>(window.columns);
        Words<L> const columns = loaded<L>(c.columns + i), rows = loaded<L>(c.rows + i);
        Words<L> const first = (columns & 0xffff) / width - column, end = ((columns >> 16 & 0xffff) + (width - 1)) / width - column;
        bits = Ellipses<L>::between_bits(limited(first, most), limited(end, most));
        y0 = rows & 0xffff, y1 = rows >> 16 & 0xffff;
    }
    TILEMESH_KERNEL Words<L> band(std::int32_t row) const noexcept
    {
        return bits & (y0 < row + static_cast<std::int32_t>(cell_height)) & (y1 > row);
    }

private:
    TILEMESH_KERNEL static Words<L> limited(Words<L> const& v, std::int32_t most) noexcept
    {
        Words<L> const low = v & (v > 0);
        return low < most ? low : broadcast_word<L>(most);
    }
};

/// The lanes of splats i to i + L - 1 that are below n.
template <std::uint32_t L>
TILEMESH_KERNEL Words<L> valid_lanes(std::uint32_t i, std::uint32_t n) noexcept
{
    return counted_lanes<L>() + static_cast<std::int32_t>(i) < static_cast<std::int32_t>(n);
}
/// The lanes in which the splats of a chunk are tested: two at least, and no more than are filled.
template <std::uint32_t N, std::uint32_t Size>
inline constexpr std::uint32_t list_lanes = N < 2 ? 2 : N > CellChunk<Size>::filled ? CellChunk<Size>::filled : N;

/// Completes the first n splats of a chunk: their words that follow from others. Returns all bits of Special that a splat has. The chunk must be
/// filled to a multiple of `CellChunk::filled`.
template <class Rule>
struct CompleteCells {
    template <class Set, std::uint32_t Size>
    TILEMESH_KERNEL static std::uint32_t run(CellChunk<Size>& c, std::uint32_t n, Camera const& camera, float alpha_max) noexcept
    {
        constexpr std::uint32_t L = list_lanes<Set::most_lanes, Size>;
        Words<L> any{};
        for (std::uint32_t i = 0; i < (n + 7) / 8 * 8; i += L) { // lists are made of 8 splats at a time
            Floats<L> const exponent = load<L>(c.across + i) * (2 * log2_e); // never above 0
            put<L>(c.q + i, power_of_two<Rule::degree, L>(at_least<L>(exponent, broadcast<L>(lowest_exponent))));
            put<L>(c.height + i, logarithm<FloatLanes<L>>(load<L>(c.opacity + i)) * log2_e);
            Words<L> const special = Ellipses<L>::complete(c, i, camera, alpha_max) & valid_lanes<L>(i, n);
            store(c.special + i, special);
            any |= special;
        }
        std::int32_t all = 0;
        for (std::uint32_t k = 0; k < L; ++k) all |= any[k];
        return static_cast<std::uint32_t>(all);
    }
};
/// Finds the cells of a window that the first n splats of a completed chunk reach.
struct ReachCells {
    template <class Set, std::uint32_t Size>
    TILEMESH_KERNEL static void run(CellChunk<Size>& c, std::uint32_t n, CellWindow const& window) noexcept
    {
        constexpr std::uint32_t L = list_lanes<Set::most_lanes, Size>;
        using A = FloatLanes<L>;
        float const y = static_cast<float>(window.row) + 0.5f - window.camera->cy;
        for (std::uint32_t i = 0; i < (n + 7) / 8 * 8; i += L) { // as in CompleteCells
            Ellipses<L> const ellipses(c, i);
            Words<L> cells{};
            for (std::uint32_t j = 0; j < window.bands; ++j)
                cells |= ellipses.band(y + static_cast<float>(cell_height * j), window) << static_cast<std::int32_t>(window.columns * j);
            Words<L> const special = loaded<L>(c.special + i);
            if (A::any(special & static_cast<std::int32_t>(Special::clipped))) cells &= in_rectangles<L>(c, i, window) | ~clips<L>(special);
            store(c.cells + i, Words<L>(cells & valid_lanes<L>(i, n)));
        }
    }

private:
    template <std::uint32_t L>
    TILEMESH_KERNEL static Words<L> clips(Words<L> const& special) noexcept
    {
        return (special & static_cast<std::int32_t>(Special::clipped)) != 0;
    }
    template <std::uint32_t L, std::uint32_t Size>
    TILEMESH_KERNEL static Words<L> in_rectangles(CellChunk<Size> const& c, std::uint32_t i, CellWindow const& window) noexcept
    {
        Rectangles<L> const rectangles(c, i, window);
        Words<L> cells{};
        for (std::uint32_t j = 0; j < window.bands; ++j)
            cells |= rectangles.band(static_cast<std::int32_t>(window.row + cell_height * j)) << static_cast<std::int32_t>(window.columns * j);
        return cells;
    }
};

/// The splats of each cell of a window, from the cells of each splat of a chunk: a scan of the chunk for each cell. A tile's worker does this
/// for few splats and few cells. Stores are whole words.
template <std::uint32_t Size>
class ScannedLists {
public:
    using Number = std::uint32_t;
    void begin(CellChunk<Size> const& chunk, std::uint32_t n, std::uint32_t) noexcept { chunk_ = &chunk, n_ = n; }
    /// Lists the splats of a cell and one number more. Returns how many they are.
    std::uint32_t list(std::uint32_t cell, std::uint32_t, Number* to) const noexcept
    {
        std::uint32_t count = 0;
        for (std::uint32_t i = 0; i < n_; ++i) { // no branch: a predictor cannot know the splats
            to[count] = i;
            count += chunk_->cells[i] >> cell & 1u;
        }
        to[count] = 0;
        return count;
    }

private:
    CellChunk<Size> const* chunk_;
    std::uint32_t n_;
};

/// The numbers of the bits that are set in a byte, as bytes of two words, and how many they are. Not every target has an instruction that
/// counts bits.
struct SetBits {
    alignas(64) std::uint32_t of[256][2];
    std::uint8_t count[256];
    constexpr SetBits() noexcept : of{}, count{}
    {
        for (std::uint32_t v = 0; v < 256; ++v)
            for (std::uint32_t i = 0; i < 8; ++i)
                if ((v >> i & 1u) != 0) {
                    std::uint32_t const at = count[v]++;
                    of[v][at / 4] |= i << at % 4 * 8;
                }
    }
};
inline constexpr SetBits set_bits{};

/// Byte k of result j is byte j of word k: swaps rows and columns of 4 x 4 bytes.
TILEMESH_KERNEL void transpose_bytes(std::uint32_t const* w, std::uint32_t (&to)[4]) noexcept
{
    constexpr std::uint32_t even = 0x00ff00ffu, low = 0x0000ffffu;
    std::uint32_t const ab02 = (w[0] & even) | (w[1] & even) << 8, ab13 = (w[0] >> 8 & even) | (w[1] & ~even);
    std::uint32_t const cd02 = (w[2] & even) | (w[3] & even) << 8, cd13 = (w[2] >> 8 & even) | (w[3] & ~even);
    to[0] = (ab02 & low) | cd02 << 16;
    to[1] = (ab13 & low) | cd13 << 16;
    to[2] = ab02 >> 16 | (cd02 & ~low);
    to[3] = ab13 >> 16 | (cd13 & ~low);
}
/// Swaps rows and columns of 8 x 8 bits, the first four rows in `v` and the others in `u` (Hacker's Delight, section 7-3).
TILEMESH_KERNEL void transpose_bits(std::uint32_t& v, std::uint32_t& u) noexcept
{
    std::uint32_t t = (v ^ v >> 7) & 0x00aa00aau, s = (u ^ u >> 7) & 0x00aa00aau;
    v ^= t ^ t << 7, u ^= s ^ s << 7;
    t = (v ^ v >> 14) & 0x0000ccccu, s = (u ^ u >> 14) & 0x0000ccccu;
    v ^= t ^ t << 14, u ^= s ^ s << 14;
    t = (v ^ u << 4) & 0xf0f0f0f0u;
    v ^= t, u ^= t >> 4;
}

/// `ScannedLists` for a host thread: it swaps the bits of 8 splats and all cells at once, and takes 8 splats of a list from a table. It stores
/// bytes.
template <std::uint32_t Size>
class SwappedLists {
public:
    using Number = std::uint8_t;
    void begin(CellChunk<Size> const& chunk, std::uint32_t n, std::uint32_t cells) noexcept
    {
        groups_ = (n + 7) / 8;
        for (std::uint32_t g = 0; g < groups_; ++g) {
            std::uint32_t first[4], last[4];
            transpose_bytes(chunk.cells + 8 * g, first);
            transpose_bytes(chunk.cells + 8 * g + 4, last);
            for (std::uint32_t byte = 0; 8 * byte < cells; ++byte) {
                transpose_bits(first[byte], last[byte]);
                std::memcpy(masks_[byte][g], &first[byte], 4);
                std::memcpy(masks_[byte][g] + 4, &last[byte], 4);
            }
        }
    }
    /// How many splats a cell has, or two cells together.
    std::uint32_t count(std::uint32_t cell, std::uint32_t other) const noexcept
    {
        std::uint32_t n = 0;
        for (std::uint32_t g = 0; g < groups_; ++g) n += set_bits.count[splats_of(g, cell) | splats_of(g, other)];
        return n;
    }
    /// Lists the splats of a cell, or of two cells together, and two numbers more. Returns how many they are.
    std::uint32_t list(std::uint32_t cell, std::uint32_t other, Number* to) const noexcept
    {
        static_assert(Size <= 256, "a number is a byte");
        Number* next = to;
        for (std::uint32_t g = 0, groups = groups_; g < groups; ++g) { // a copy: a store of bytes might change the member
            std::uint32_t const splats = splats_of(g, cell) | splats_of(g, other);
            std::uint32_t const numbers[2] = {set_bits.of[splats][0] + g * 0x08080808u, set_bits.of[splats][1] + g * 0x08080808u};
            std::memcpy(next, numbers, sizeof numbers);
            next += set_bits.count[splats];
        }
        next[0] = next[1] = 0;
        return static_cast<std::uint32_t>(next - to);
    }

private:
    std::uint32_t splats_of(std::uint32_t g, std::uint32_t cell) const noexcept { return masks_[cell / 8][g][cell % 8]; }

    std::uint32_t groups_;
    std::uint8_t masks_[4][Size / 8][8];
};

#if defined(__AVX512F__) && defined(__AVX512DQ__)
template <std::uint32_t Size>
using HostLists = std::conditional_t<(Size >= 64), MaskedLists<Size>, SwappedLists<Size>>;
#else
template <std::uint32_t Size>
using HostLists = SwappedLists<Size>;
#endif
template <std::uint32_t Size>
using ListsOf = std::conditional_t<(Size > 16), HostLists<Size>, ScannedLists<Size>>;

}}} // namespace tilemesh::splat::detail
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
