#pragma once
#include <cmath>
#include <cstddef>
#include <tilemesh/splat/blending_rules.hpp>
#include <tilemesh/splat/policies.hpp>
#include <type_traits>
#include <utility>

/// The memory of blending in cells (blending_cells.hpp): a chunk of splats, and the state of a cell.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::detail {

inline constexpr float log2_e = 1.44269504088896341f;

/// `store` of a copy: of a reference to an array's element, GCC 12 would keep the array in memory.
template <std::uint32_t N>
TILEMESH_KERNEL void put(float* to, Floats<N> const& v) noexcept
{
    Floats<N> const copy = v;
    std::memcpy(to, &copy, sizeof copy);
}

/// A splat as a cell reads it: one cache line, because a chunk begins on one.
struct CellSplat {
    float mean_x, mean_y;
    float along2;          ///< along log2(e)
    float tilt;            ///< -slope
    float across2;         ///< across log2(e)
    float opacity;
    float red, green, blue;
    std::uint32_t depth_key;     ///< as in Splat
    float faintest;
    std::uint32_t columns, rows; ///< as in Splat
    std::uint32_t unused[3];
};
static_assert(sizeof(CellSplat) == 64, "a cache line where vectors are wide");

/// Why a splat needs more than the recurrence.
struct Special {
    static constexpr std::uint32_t apart = 1;   ///< it is evaluated pair by pair: it is sharp or a needle (cell_lists.hpp)
    static constexpr std::uint32_t clamped = 2; ///< alpha may exceed alpha_max
    static constexpr std::uint32_t clipped = 4; ///< its rectangle cuts pixels whose alpha is above the cut
};
/// Needs a splat with these bits of Special no more than the recurrence and the clamp?
TILEMESH_KERNEL constexpr bool recurs(std::uint32_t special) noexcept { return (special & ~Special::clamped) == 0; }

/// No column with a pixel above the cut (2^-13 or more) rises by more than 2^steepest_rise from the first row to the second, or begins below
/// 2^-126, if a = -across log2(e) is at most `sharpest`: with |off| <= sqrt(13 / a) at a visible row, the first of four rows has a power of
/// at least -(sqrt(13) + 3 sqrt(a))^2 = -93, and it rises by at most 2 sqrt(13 a) + 5 a = 35. In a column that begins lower, the clamps keep all
/// four rows below 2^(3 * 37 - 126) = 2^-15. A dilation of 0.3 gives a <= 2.41.
inline constexpr float steepest_rise = 37.0f, sharpest = 4.0f, lowest_exponent = -126.0f;
/// alpha of the recurrence is below the opacity times 1 + 2^-16. So a splat whose opacity is less than this share of alpha_max needs no clamp.
inline constexpr float below_the_clamp = 1.0f - 0x1p-16f;

/// A chunk of splats, and what follows from them.
template <std::uint32_t Size>
struct alignas(vector_bytes) CellChunk {
    static_assert(Size % 8 == 0, "lanes are filled");
    static constexpr std::uint32_t size = Size, filled = Size % 16 == 0 ? 16 : 8;
    CellSplat splats[Size];
    float q[Size];               ///< 2^(2 across): the ratio of two ratios of the recurrence
    float height[Size];          ///< log2(opacity)
    std::uint32_t special[Size]; ///< bits of Special
    std::uint32_t cells[Size];   ///< the cells of a window that the splat reaches, as bits
    float mean_x[Size], mean_y[Size], along[Size], slope[Size], across[Size], opacity[Size], faintest[Size];
    std::uint32_t columns[Size], rows[Size];
    float right[Size]; ///< of the ellipse at the cut, which then stands in the place of these fields (Ellipses::complete)

    void take(std::uint32_t i, Splat const& s) noexcept
    {
        splats[i] = {s.mean_px[0], s.mean_px[1], s.along * log2_e, -s.slope, s.across * log2_e, s.opacity, s.colour[0], s.colour[1],
                     s.colour[2], s.depth_key, s.faintest, s.columns, s.rows, {0, 0, 0}};
        mean_x[i] = s.mean_px[0], mean_y[i] = s.mean_px[1];
        along[i] = s.along, slope[i] = s.slope, across[i] = s.across;
        opacity[i] = s.opacity, faintest[i] = s.faintest;
        columns[i] = s.columns, rows[i] = s.rows;
    }
    /// `take` for four splats.
    void take_four(std::uint32_t i, Splat const& s, Splat const& t, Splat const& u, Splat const& v) noexcept
    {
        static_assert(offsetof(Splat, mean_px) == 0 && offsetof(Splat, along) == 8 && offsetof(Splat, slope) == 12);
        static_assert(offsetof(Splat, across) == 16 && offsetof(Splat, opacity) == 20 && offsetof(Splat, colour) == 24);
        static_assert(offsetof(Splat, depth_key) == 36 && offsetof(Splat, faintest) == 40 && offsetof(Splat, columns) == 44);
        Splat const* const from[4] = {&s, &t, &u, &v};
        Floats<4> a[4], b[4], c[4];
        for (std::uint32_t k = 0; k < 4; ++k) {
            auto const* const words = reinterpret_cast<char const*>(from[k]);
            std::memcpy(&a[k], words, 16), std::memcpy(&b[k], words + 16, 16), std::memcpy(&c[k], words + 32, 16);
            CellSplat& to = splats[i + k];
            put<4>(&to.mean_x, a[k] * Floats<4>{1, 1, log2_e, -1});
            put<4>(&to.across2, b[k] * Floats<4>{log2_e, 1, 1, 1});
            put<4>(&to.blue, c[k]);
            to.rows = rows[i + k] = from[k]->rows;
        }
        float unused_green[4], unused_red[4], unused_depth[4], unused_blue[4], packed[4];
        store_transposed(a[0], a[1], a[2], a[3], mean_x + i, mean_y + i, along + i, slope + i);
        store_transposed(b[0], b[1], b[2], b[3], across + i, opacity + i, unused_red, unused_green);
        store_transposed(c[0], c[1], c[2], c[3], unused_blue, unused_depth, faintest + i, packed);
        std::memcpy(columns + i, packed, sizeof packed);
    }
};

/// Fills a chunk with the splats from `begin` on, at most `Size` of n, and returns their number.
template <bool ByFour, std::uint32_t Size, class SplatAt>
TILEMESH_KERNEL std::uint32_t fill(CellChunk<Size>& chunk, std::uint32_t begin, std::uint32_t n, SplatAt const& at) noexcept
{
    std::uint32_t const most = n - begin < Size ? n - begin : Size;
    std::uint32_t i = 0;
    for (; ByFour && i + 4 <= most; i += 4) chunk.take_four(i, at(begin + i), at(begin + i + 1), at(begin + i + 2), at(begin + i + 3));
    for (; i < most; ++i) chunk.take(i, at(begin + i));
    constexpr std::uint32_t filled = CellChunk<Size>::filled;
    for (i = most; i < (most + filled - 1) / filled * filled; ++i) chunk.take(i, at(begin)); // fills the lanes; not listed
    return most;
}

/// At most 32 cells, a rectangle of the frame's grid of cells: those that share one pass over the splats.
struct CellWindow {
    std::uint32_t column, row;     ///< the first cell's first pixel
    std::uint32_t columns, bands;  ///< in cells; their product is at most 32
    Camera const* camera;
};
/// The state of a cell, row by row. Pixels that take no part are dead: their transmittance is negative. So is that of a pixel that has stopped
/// before a term (StopBeforeCrossing).
struct CellFields {
    float transmittance[cell_height][cell_width];
    float red[cell_height][cell_width], green[cell_height][cell_width], blue[cell_height][cell_width];
    std::int32_t contributing[cell_width]; ///< pairs that contributed, column by column
    static constexpr bool has_depth = false;
};
struct DepthCellFields : CellFields {
    float weight[cell_height][cell_width], depth[cell_height][cell_width];
    static constexpr bool has_depth = true;
};
template <bool HasDepth>
struct alignas(vector_bytes) Cell : std::conditional_t<HasDepth, DepthCellFields, CellFields> {};

using CellRows = std::make_integer_sequence<std::uint32_t, cell_height>;

/// The place of a cell: its first pixel, and the camera's principal point.
struct CellPlace {
    std::uint32_t column, row;
    float cx, cy;
};

/// A cell in progress.
template <bool HasDepth>
struct OpenCell {
    Cell<HasDepth> state;
    CellPlace at;
    std::uint32_t number;  ///< in the tile, row by row
    std::uint32_t in_window; ///< its bit in CellChunk::cells
    std::uint32_t columns; ///< those that are blended, as bits
    std::uint32_t blended; ///< splats so far, or since the last look at the end of a group
    std::uint32_t going;   ///< 1 if a pixel went on after the last batch

    /// Makes the cell black. Pixels outside `live` are dead.
    void begin(CellPlace const& place, PixelRect const& live) noexcept
    {
        at = place;
        clear(CellRows{});
        bool const whole = place.column >= live.x0 && place.column + cell_width <= live.x1 && place.row >= live.y0 &&
                           place.row + cell_height <= live.y1;
        for (std::uint32_t j = 0; j < cell_height && !whole; ++j)
            for (std::uint32_t i = 0; i < cell_width; ++i) {
                std::uint32_t const x = place.column + i, y = place.row + j;
                if (!(x >= live.x0 && x < live.x1 && y >= live.y0 && y < live.y1)) state.transmittance[j][i] = -1.0f;
            }
        columns = (1u << cell_width) - 1;
        blended = 0;
        going = 1;
    }
    std::uint32_t contributing() const noexcept
    {
        std::int32_t sum = 0;
        for (std::int32_t const one : state.contributing) sum += one;
        return static_cast<std::uint32_t>(sum);
    }

private:
    /// Written out: GCC 12 calls memset for what takes 17 stores.
    template <std::uint32_t... V>
    void clear(std::integer_sequence<std::uint32_t, V...>) noexcept
    {
        Floats<cell_width> const none{}, all = none + 1.0f;
        (put<cell_width>(state.transmittance[V], all), ...);
        (put<cell_width>(state.red[V], none), ...), (put<cell_width>(state.green[V], none), ...), (put<cell_width>(state.blue[V], none), ...);
        store(state.contributing, Words<cell_width>{});
        if constexpr (HasDepth) (put<cell_width>(state.weight[V], none), ...), (put<cell_width>(state.depth[V], none), ...);
    }
};

/// Adds the background that shows through the pixels of a cell.
inline void add_background(CellFields& cell, float const (&background)[3]) noexcept
{
    for (std::uint32_t j = 0; j < cell_height; ++j)
        for (std::uint32_t i = 0; i < cell_width; ++i) {
            float const through = std::fabs(cell.transmittance[j][i]);
            cell.red[j][i] = multiply_add(through, background[0], cell.red[j][i]);
            cell.green[j][i] = multiply_add(through, background[1], cell.green[j][i]);
            cell.blue[j][i] = multiply_add(through, background[2], cell.blue[j][i]);
        }
}
template <class AnyCell>
Blended blended_in(AnyCell const& cell, std::uint32_t row, std::uint32_t column) noexcept
{
    Blended b{{cell.red[row][column], cell.green[row][column], cell.blue[row][column]}, std::fabs(cell.transmittance[row][column]), 0, 0};
    if constexpr (AnyCell::has_depth) {
        b.weight = cell.weight[row][column];
        b.depth = cell.depth[row][column];
    }
    return b;
}

}}} // namespace tilemesh::splat::detail
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
