#pragma once
#include <cstdint>
#include <tilemesh/splat/blending_rules.hpp>
#include <tilemesh/splat/homes/fold.hpp>
#include <tilemesh/splat/projection.hpp>

/// The splats of a window that each block of a tile may show, for a host thread. The blocks of a folded tile lie far apart, so most splats
/// reach one of them.
TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace splat::homes::detail {

/// Blocks of a tile, at most 32: columns [first_column, first_column + columns) of its blocks, and as many rows. Block k of the group has
/// column k % columns and row k / columns.
struct BlockGroup {
    static constexpr std::uint32_t most = 32;
    std::uint32_t first_column, first_row, columns, rows;

    std::uint32_t count() const noexcept { return columns * rows; }
    /// The number of block k on its tile.
    std::uint32_t number(std::uint32_t k, Fold const& fold) const noexcept
    {
        return (first_row + k / columns) * fold.x.layers + first_column + k % columns;
    }
};
/// Calls f(group) for groups that make up all blocks of a tile.
template <class F>
void for_each_group(Fold const& fold, F const& f) noexcept
{
    std::uint32_t const columns = fold.x.layers < BlockGroup::most ? fold.x.layers : BlockGroup::most, rows = BlockGroup::most / columns;
    for (std::uint32_t row = 0; row < fold.y.layers; row += rows)
        for (std::uint32_t column = 0; column < fold.x.layers; column += columns)
            f(BlockGroup{column, row, fold.x.layers - column < columns ? fold.x.layers - column : columns,
                         fold.y.layers - row < rows ? fold.y.layers - row : rows});
}

/// Which blocks of a group a splat may reach along one axis, as bits: two tables of coarse pixels, without a loop over the blocks.
class ReachedBlocks {
public:
    /// Blocks `first` to `first + n - 1` of those that a tile has along an axis of `extent` pixels; block k is bit k * stride. `size`: of a
    /// block, pixels. `margin`: pixels around a block. A splat reaches cells, which may stand out over the block by a cell.
    ReachedBlocks(Axis const& axis, std::uint32_t tile, std::uint32_t first, std::uint32_t n, std::uint32_t stride, std::uint32_t size,
                  std::uint32_t extent, std::uint32_t margin) noexcept
    {
        while ((extent - 1) >> shift_ >= coarse) ++shift_;
        std::uint32_t const last = (extent - 1) >> shift_;
        for (std::uint32_t c = 0; c <= last; ++c) begins_[c] = ends_[c] = 0;
        for (std::uint32_t k = 0; k < n; ++k) {
            std::uint32_t const block = axis.block(tile, first + k), at = block * size;
            if (block >= axis.blocks) continue;
            std::uint32_t const bit = 1u << k * stride, begin = (at < margin ? 0 : at - margin) >> shift_, end = (at + size - 1 + margin) >> shift_;
            for (std::uint32_t c = begin; c <= last; ++c) begins_[c] |= bit;
            for (std::uint32_t c = 0; c <= (end < last ? end : last); ++c) ends_[c] |= bit;
        }
    }
    /// The blocks near pixels of a span, x0 | x1 << 16, that lie within the extent.
    std::uint32_t of(std::uint32_t span) const noexcept { return begins_[((span >> 16) - 1) >> shift_] & ends_[(span & 0xffffu) >> shift_]; }

private:
    static constexpr std::uint32_t coarse = 128;
    std::uint32_t shift_ = 2;
    std::uint32_t begins_[coarse], ends_[coarse]; ///< the blocks that begin before a coarse pixel ends, and end behind its beginning
};

/// Lists the splats that may reach each block of a group, in their order.
class BlockLists {
public:
    BlockLists(Fold const& fold, TileId tile, BlockGroup const& group, Camera const& camera) noexcept
        : centre_{camera.cx, camera.cy}, far_(2 * static_cast<float>(camera.width + camera.height)),
          columns_(fold.x, tile.x(), group.first_column, group.columns, 1, block_width, camera.width, margin(camera)),
          rows_(fold.y, tile.y(), group.first_row, group.rows, group.columns, block_height, camera.height, margin(camera))
    {
    }
    /// Lists those of the splats from `first` on that may reach one of the blocks `open`, as many as there is room for. Returns the number of
    /// the next splat.
    template <class SplatAt>
    std::uint32_t list(std::uint32_t first, std::uint32_t n, std::uint32_t open, SplatAt const& at) noexcept
    {
        constexpr std::uint32_t ahead = 32; // splats: the host's memory answers that late
        std::uint32_t const most = n - first < most_splats ? n - first : most_splats;
        auto const fetch = [&](std::uint32_t i) noexcept {
            splats_[i] = &at(first + i);
            __builtin_prefetch(splats_[i]);
            __builtin_prefetch(&splats_[i]->rows);
        };
        for (std::uint32_t i = 0; i < most && i < ahead; ++i) fetch(i);
        std::uint32_t counts[BlockGroup::most] = {}, entries = 0, splats = 0;
        for (; splats < most && entries + BlockGroup::most <= most_entries; ++splats) {
            if (splats + ahead < most) fetch(splats + ahead);
            Splat const& s = *splats_[splats];
            std::uint32_t blocks = open & (is_near(s) ? columns_.of(s.columns) * rows_.of(s.rows) : ~0u);
            blocks_[splats] = blocks;
            for (; blocks != 0; blocks &= blocks - 1, ++entries) ++counts[lowest(blocks)];
        }
        std::uint32_t next[BlockGroup::most];
        begin_[0] = 0;
        for (std::uint32_t k = 0; k < BlockGroup::most; ++k) next[k] = begin_[k], begin_[k + 1] = begin_[k] + counts[k];
        for (std::uint32_t i = 0; i < splats; ++i)
            for (std::uint32_t blocks = blocks_[i]; blocks != 0; blocks &= blocks - 1) entries_[next[lowest(blocks)]++] = splats_[i];
        return first + splats;
    }
    /// The list of block k.
    struct List {
        Splat const* const* splats;
        std::uint32_t count;
        Splat const& operator()(std::uint32_t i) const noexcept { return *splats[i]; }
    };
    List of(std::uint32_t k) const noexcept { return {entries_ + begin_[k], begin_[k + 1] - begin_[k]}; }

private:
    static constexpr std::uint32_t most_splats = 1024, most_entries = 1536;

    /// The rectangle of a splat is that of its ellipse at the cut. The ellipse that says which cells it reaches has margins, and its rectangle
    /// may cut off a ten-thousandth of it (cell_lists.hpp). A splat with a mean within twice the frame's sides, of whose rectangle an edge is
    /// in the frame, reaches at most three times as far. Rectangles are whole pixels, so on small ellipses no margin shows.
    static std::uint32_t margin(Camera const& camera) noexcept { return cell_height + 4 + (camera.width + camera.height) / 2048; }
    /// A splat whose mean is farther away may reach any block.
    bool is_near(Splat const& s) const noexcept
    {
        auto const within = [&](float v) { return v <= far_ && v >= -far_; };
        return within(s.mean_px[0]) && within(s.mean_px[1]) && within(s.mean_px[0] + centre_[0]) && within(s.mean_px[1] + centre_[1]);
    }
    static std::uint32_t lowest(std::uint32_t bits) noexcept { return static_cast<std::uint32_t>(__builtin_ctz(bits)); }

    float centre_[2], far_;
    ReachedBlocks columns_, rows_;
    std::uint32_t begin_[BlockGroup::most + 1];
    Splat const* splats_[most_splats];
    std::uint32_t blocks_[most_splats]; ///< of each splat, as bits
    Splat const* entries_[most_entries];
};

}}} // namespace tilemesh::splat::homes::detail
TILEMESH_EXACT_END
