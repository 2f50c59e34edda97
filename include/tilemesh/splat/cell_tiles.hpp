#pragma once
#include <tilemesh/splat/cell_window.hpp>
#include <type_traits>

/// Blends a list of splats into the cells of a tile, in windows of at most 32 cells, and writes their pixels.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::detail {

/// Counts the pairs of a tile's cells: `counts[number % workers]` gets those of cell `number`.
struct TileTally {
    static constexpr bool by_groups = true;
    PairCount* counts;
    std::uint32_t workers;

    template <class AnyCell>
    void evaluated(AnyCell const& cell, std::uint32_t splats) const noexcept
    {
        static_assert(cell_width * cell_height % pairs_a_count == 0, "pairs are counted in whole units");
        counts[cell.number % workers].evaluated += splats * (cell_width * cell_height / pairs_a_count);
    }
    template <class AnyCell>
    static void look(AnyCell& cell) noexcept
    {
        if (cell.going == 0) cell.columns = 0;
    }
};

/// Stores four reds, greens and blues as four pixels.
TILEMESH_KERNEL void store_interleaved(float* to, float const* red, float const* green, float const* blue) noexcept
{
    auto const x = load<4>(red), y = load<4>(green), z = load<4>(blue);
    Floats<4> const xy = __builtin_shufflevector(x, y, 0, 4, 1, 5), zx = __builtin_shufflevector(z, x, 0, 0, 5, 5);
    store(to, Floats<4>(__builtin_shufflevector(xy, zx, 0, 1, 4, 6)));
    Floats<4> const yz = __builtin_shufflevector(y, z, 1, 5, 2, 6), xy2 = __builtin_shufflevector(x, y, 2, 2, 6, 6);
    store(to + 4, Floats<4>(__builtin_shufflevector(yz, xy2, 0, 1, 4, 6)));
    Floats<4> const zx3 = __builtin_shufflevector(z, x, 2, 7, 3, 3), yz3 = __builtin_shufflevector(y, z, 3, 3, 7, 7);
    store(to + 8, Floats<4>(__builtin_shufflevector(zx3, yz3, 0, 1, 4, 6)));
}
/// Writes those pixels of a cell that lie in the tile.
template <class AnyCell, class Pixel>
void write_cell(AnyCell& cell, PixelRect const& tile, Rules const& rules, Pixel* pixels, std::uint32_t stride_px) noexcept
{
    if (!is_black(rules.background)) add_background(cell.state, rules.background);
    auto const& at = cell.at;
    for (std::uint32_t j = 0; j < cell_height; ++j) {
        std::uint32_t const y = at.row + j;
        if (y < tile.y0 || y >= tile.y1) continue;
        Pixel* const row = pixels + (y - tile.y0) * stride_px;
        if (at.column >= tile.x0 && at.column + cell_width <= tile.x1) { // almost always
            if constexpr (std::is_same_v<Pixel, FloatPixel>)
                for (std::uint32_t i = 0; i < cell_width; i += 4)
                    store_interleaved(row[at.column - tile.x0 + i].rgb, cell.state.red[j] + i, cell.state.green[j] + i, cell.state.blue[j] + i);
            else
                for (std::uint32_t i = 0; i < cell_width; ++i) row[at.column - tile.x0 + i] = Pixel::make(blended_in(cell.state, j, i));
        } else {
            for (std::uint32_t i = 0; i < cell_width; ++i)
                if (at.column + i >= tile.x0 && at.column + i < tile.x1) row[at.column + i - tile.x0] = Pixel::make(blended_in(cell.state, j, i));
        }
    }
}

/// The cells of a tile, and its windows: each is as wide as the tile, at most 8 cells, and has as many bands as fit.
struct TileCells {
    std::uint32_t left, top, across, down; ///< the first cell's first pixel; the number of cells
    std::uint32_t columns, bands;          ///< of a window

    explicit TileCells(PixelRect const& tile) noexcept
        : left(tile.x0 / cell_width * cell_width), top(tile.y0 / cell_height * cell_height),
          across((tile.x1 - left + cell_width - 1) / cell_width), down((tile.y1 - top + cell_height - 1) / cell_height),
          columns(across < 8 ? across : 8), bands(32 / columns)
    {
    }
    /// The cells [column, column + columns) x [band, band + bands) that exist.
    CellWindow window(std::uint32_t column, std::uint32_t band, std::uint32_t most_bands, Camera const& camera) const noexcept
    {
        return {left + column * cell_width, top + band * cell_height, across - column < columns ? across - column : columns, most_bands, &camera};
    }
};

/// `blend_tile` in cells. At most Memory::group cells are open at once.
template <class Rule, class Stop, std::uint32_t N, class Memory, class Pixel, class SplatAt>
void blend_tile_in_cells(Memory& m, PixelRect const& tile, Camera const& camera, Rules const& rules, std::uint32_t n, SplatAt const& at,
                         Pixel* pixels, std::uint32_t stride_px, Worker worker, PairCount* counts, std::uint32_t workers) noexcept
{
    typename Rule::Denormals const denormals;
    TileCells const cells(tile);
    for (std::uint32_t y = tile.y0; y < tile.y1 && worker.count == 1; ++y) fetch_row_ahead(pixels + (y - tile.y0) * stride_px, 0u, tile.x1 - tile.x0);
    for (std::uint32_t band0 = 0; band0 < cells.down; band0 += cells.bands)
        for (std::uint32_t column0 = 0; column0 < cells.across; column0 += cells.columns) {
            std::uint32_t const last = band0 + cells.bands < cells.down ? band0 + cells.bands : cells.down;
            auto window = cells.window(column0, band0, 1, camera);
            std::uint32_t const all = window.columns * (last - band0);
            for (std::uint32_t next = 0; next < all;) {
                std::uint32_t open = 0, first = 0;
                for (; open < Memory::group && next < all; ++next) {
                    std::uint32_t const column = column0 + next % window.columns, band = band0 + next / window.columns;
                    std::uint32_t const number = band * cells.across + column;
                    if (number % worker.count != worker.index) continue;
                    if (open == 0) first = next / window.columns;
                    auto& cell = m.cells[open++];
                    cell.number = number;
                    cell.in_window = next - first * window.columns;
                    cell.begin({cells.left + column * cell_width, cells.top + band * cell_height, camera.cx, camera.cy}, tile);
                    window.bands = next / window.columns - first + 1;
                }
                if (open == 0) break;
                window.row = cells.top + (band0 + first) * cell_height;
                blend_open_cells<Rule, Stop, N>(m, window, open, rules, n, at, TileTally{counts, workers});
                for (std::uint32_t b = 0; b < open; ++b) {
                    counts[m.cells[b].number % workers].contributing += m.cells[b].contributing();
                    write_cell(m.cells[b], tile, rules, pixels, stride_px);
                }
            }
        }
}

}}} // namespace tilemesh::splat::detail
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
