#pragma once
#include <cstdint>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/splat/blending_rules.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 { namespace splat::homes {

/// The division of one axis of the frame: which tile owns a column (or row) of blocks.
///
/// Without a fold, neighbouring blocks lie on one tile: block i on tile i / layers. With a fold, the blocks run across the grid to and fro,
/// as a sheet of paper is folded, so that a crowd of splats in one place of the picture spreads over many tiles. The folds are shifted so
/// that the picture's middle lies in one layer. In both forms an interval of blocks is an interval of tiles.
struct Axis {
    std::uint32_t blocks; ///< of the frame
    std::uint32_t tiles;  ///< that hold blocks
    std::uint32_t layers; ///< blocks of a tile, at most
    std::uint32_t shift;  ///< blocks that the first layer leaves out
    std::uint32_t folded; ///< 0 or 1

    /// The tile of block i, i < blocks.
    constexpr std::uint32_t tile_of(std::uint32_t i) const noexcept
    {
        if (folded == 0) return i / layers;
        std::uint32_t const at = (i + shift) % tiles;
        return (i + shift) / tiles % 2 == 0 ? at : tiles - 1 - at;
    }
    /// The block that tile t has as its number k, k < layers. If it has fewer, the result is not below `blocks`.
    constexpr std::uint32_t block(std::uint32_t t, std::uint32_t k) const noexcept
    {
        if (folded == 0) return t * layers + k;
        std::uint32_t const layer = k + (t < shift ? 1u : 0u);
        return layer * tiles + (layer % 2 == 0 ? t : tiles - 1 - t) - shift;
    }
    /// Goes through blocks in order without divisions: the tile of a block, and its number on that tile.
    struct Cursor {
        std::uint32_t layer, at;
    };
    constexpr Cursor cursor(std::uint32_t i) const noexcept
    {
        std::uint32_t const size = folded == 0 ? layers : tiles;
        return {(i + shift) / size, (i + shift) % size};
    }
    constexpr Cursor next(Cursor c) const noexcept
    {
        return ++c.at < (folded == 0 ? layers : tiles) ? c : Cursor{c.layer + 1, 0};
    }
    constexpr std::uint32_t tile(Cursor c) const noexcept { return folded == 0 ? c.layer : c.layer % 2 == 0 ? c.at : tiles - 1 - c.at; }
    constexpr std::uint32_t number(Cursor c) const noexcept
    {
        return folded == 0 ? c.at : c.layer - (tile(c) < shift ? 1u : 0u);
    }
    /// The tiles, first to last, of blocks i to j, i <= j < blocks.
    struct Range {
        std::uint32_t first, last;
    };
    constexpr Range tiles_of(std::uint32_t i, std::uint32_t j) const noexcept
    {
        return between(tile_of(i), tile_of(j), (i + shift) / tiles, (j + shift) / tiles);
    }
    /// The tiles of blocks that begin on tile a of layer `from` and end on tile b of layer `to`. Without a fold it reads no layer.
    constexpr Range between(std::uint32_t a, std::uint32_t b, std::uint32_t from, std::uint32_t to) const noexcept
    {
        std::uint32_t const low = a < b ? a : b, high = a < b ? b : a;
        if (folded == 0) return {a, b};
        if (from == to) return {low, high};
        if (to - from > 1) return {0, tiles - 1};
        return from % 2 == 0 ? Range{low, tiles - 1} : Range{0, high}; // the sheet turns at the last tile, or at the first
    }
};

/// The blocks of a frame on a grid. A tile owns every block whose column and row it owns; its block number is row number * layers in x +
/// column number.
struct Fold {
    Axis x, y;
    std::uint32_t blocks_a_bit; ///< blocks that share a bit of `finished`, so that the bits of any tile fit into a word

    constexpr std::uint32_t tile_blocks() const noexcept { return x.layers * y.layers; }
    constexpr std::uint32_t bit_of(std::uint32_t number) const noexcept { return 1u << (number / blocks_a_bit); }
};
static_assert(std::is_trivially_copyable_v<Fold>, "a fold is plain words");

/// An axis as a table of its blocks, for a host that asks for many of them: without divisions. Requires blocks <= most.
class AxisTable {
public:
    static constexpr std::uint32_t most = 512;
    explicit AxisTable(Axis const& axis) noexcept : tiles(axis.tiles), layers(axis.layers), axis_(axis)
    {
        auto c = axis.cursor(0);
        for (std::uint32_t i = 0; i < axis.blocks; ++i, c = axis.next(c))
            at_[i] = {static_cast<std::uint16_t>(c.layer), static_cast<std::uint16_t>(axis.tile(c)), static_cast<std::uint16_t>(axis.number(c))};
    }
    using Cursor = std::uint32_t;
    Cursor cursor(std::uint32_t i) const noexcept { return i; }
    Cursor next(Cursor c) const noexcept { return c + 1; }
    std::uint32_t tile(Cursor c) const noexcept { return at_[c].tile; }
    std::uint32_t number(Cursor c) const noexcept { return at_[c].number; }
    std::uint32_t block(std::uint32_t t, std::uint32_t k) const noexcept { return axis_.block(t, k); }
    Axis::Range tiles_of(std::uint32_t i, std::uint32_t j) const noexcept
    {
        return axis_.between(at_[i].tile, at_[j].tile, at_[i].layer, at_[j].layer);
    }

    std::uint32_t tiles, layers;

private:
    struct At {
        std::uint16_t layer, tile, number;
    };
    Axis const& axis_;
    At at_[most];
};
/// A fold as tables.
struct FoldTable {
    AxisTable x, y;
    std::uint32_t blocks_a_bit;
    explicit FoldTable(Fold const& fold) noexcept : x(fold.x), y(fold.y), blocks_a_bit(fold.blocks_a_bit) {}
    static bool has_room(Fold const& fold) noexcept { return fold.x.blocks <= AxisTable::most && fold.y.blocks <= AxisTable::most; }
    std::uint32_t bit_of(std::uint32_t number) const noexcept { return 1u << (blocks_a_bit == 1 ? number : number / blocks_a_bit); }
};

constexpr Axis make_axis(std::uint32_t blocks, std::uint32_t tiles, bool folded) noexcept
{
    std::uint32_t const layers = (blocks + tiles - 1) / tiles;
    if (!folded || layers == 1) return {blocks, (blocks + layers - 1) / layers, layers, 0, 0};
    return {blocks, tiles, layers, layers % 2 == 0 ? tiles / 2 : 0, 1};
}
/// The fold of a frame of width x height pixels on a grid; `folded` false: without folds. The last blocks may leave the frame.
constexpr Fold make_fold(std::uint32_t width, std::uint32_t height, Grid grid, bool folded) noexcept
{
    Fold fold{make_axis((width + block_width - 1) / block_width, grid.width, folded),
              make_axis((height + block_height - 1) / block_height, grid.height, folded), 1};
    fold.blocks_a_bit = (fold.tile_blocks() + 31) / 32;
    return fold;
}

}}} // namespace tilemesh::splat::homes
