#pragma once
#include <tilemesh/splat/map/walk.hpp>

/// Both walks for the pixels of a tile that consists of whole blocks: the picture, its loss, and the sums of each splat.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::map {

/// What both walks need besides the splats. `background` is the view's.
struct WalkRules {
    Rules rules;
    LossRules loss;
};

/// The memory of a worker that has `Group` blocks open at once. 4.5 KB a block; 232 bytes a splat of a chunk.
template <std::uint32_t Group, std::uint32_t Size>
struct WalkMemory {
    static constexpr std::uint32_t group = Group, size = Size;
    splat::detail::OpenBlock<true> open[Group];
    WalkingBlock walking[Group];
    WalkChunk<Size> chunk;
    std::uint32_t hits[Size + 16];
};

/// A block after the first walk. `live`: its pixels that lie in the tile; the block begins at (`at.column`, `at.row`).
using BlendedBlock = splat::detail::OpenBlock<true>;

/// Pixel (x, y) of the frame, which lies in the block, without the background.
inline Blended pixel_of(BlendedBlock const& block, std::uint32_t x, std::uint32_t y) noexcept
{
    return splat::detail::blended(block.state, y - static_cast<std::uint32_t>(block.at.row),
                                  x - static_cast<std::uint32_t>(block.at.column));
}

/// Does each tile of this size consist of whole blocks, wherever the frame ends? Then a block belongs to one tile of any such tiling, and
/// the sums of a splat do not depend on the tiling.
constexpr bool has_whole_blocks(TileSize const& tile) noexcept
{
    return tile.tile_width != 0 && tile.tile_height != 0 && tile.tile_width % block_width == 0 && tile.tile_height % block_height == 0;
}

namespace detail {
/// The targets of a block's pixels that lie in the tile. `pixels`: those of the tile, row by row.
inline void take_target(BlockTarget& to, splat::detail::OpenBlock<true> const& block, PixelRect const& tile, TargetPixel const* pixels,
                        std::uint32_t stride_px) noexcept
{
    for (std::uint32_t j = 0; j < block_height; ++j)
        for (std::uint32_t i = 0; i < block_width; ++i) {
            std::uint32_t const x = static_cast<std::uint32_t>(block.at.column) + i, y = static_cast<std::uint32_t>(block.at.row) + j;
            bool const inside = x >= block.live.x0 && x < block.live.x1 && y >= block.live.y0 && y < block.live.y1;
            float const nan = std::numeric_limits<float>::quiet_NaN();
            TargetPixel const p = inside ? pixels[(y - tile.y0) * stride_px + x - tile.x0] : TargetPixel{{nan, nan, nan}, 0};
            for (std::uint32_t c = 0; c < 3; ++c) to.field[c][j][i] = p.rgb[c];
            to.field[3][j][i] = p.depth;
        }
}

/// Calls `blend(block, hits, count)` for at most blended_between_looks splats at a time, chunk after chunk, for all open blocks, until
/// all pixels of a block have stopped. `each(begin, n)` is called after each chunk; `transmittance(b)` are the rows of block b.
template <std::uint32_t Group, std::uint32_t Size, class Set, class SplatAt, class Prepare, class Blend, class Each>
void through_chunks(Set const& set, WalkMemory<Group, Size>& memory, std::uint32_t open, std::uint32_t n, SplatAt const& at,
                    Prepare const& prepare,
                    Blend const& blend, Each const& each) noexcept
{
    using namespace splat::detail;
    for (std::uint32_t b = 0; b < open; ++b) memory.open[b].done = false, memory.open[b].blended = 0;
    std::uint32_t going = open;
    for (std::uint32_t begin = 0; begin < n && going != 0; begin += Size) {
        std::uint32_t const most = fill(set, static_cast<Chunk<Size>&>(memory.chunk), begin, n, at);
        prepare(begin, most);
        for (std::uint32_t b = 0; b < open; ++b) {
            auto& block = memory.open[b];
            if (block.done) continue;
            std::uint32_t const count = set.template call<ListHits>(static_cast<Chunk<Size> const&>(memory.chunk), most, block.at,
                                                                    &memory.hits[0]);
            for (std::uint32_t done = 0; done < count && !block.done;) {
                std::uint32_t part = blended_between_looks - block.blended % blended_between_looks;
                if (part > count - done) part = count - done;
                bool const stopped = blend(b, memory.hits + done, part, block.blended + part);
                done += part;
                block.blended += part;
                if (stopped) block.done = true, --going;
            }
        }
        each(begin, most);
    }
}
inline bool all_stopped(float const (&transmittance)[block_height][block_width], float least) noexcept
{
    std::uint32_t going = 0;
    for (auto const& row : transmittance)
        for (float const t : row) going |= t >= least ? 1u : 0u;
    return going == 0;
}

template <class Stop, std::uint32_t Lanes, std::uint32_t Group, std::uint32_t Size, class SplatAt, class Seen, class Add>
[[gnu::noinline]] void walk_tile_by(WalkMemory<Group, Size>& memory, PixelRect const& tile, Camera const& camera, WalkRules const& w,
                                    std::uint32_t n, SplatAt const& at,
                  TargetPixel const* target, std::uint32_t stride_px, Worker worker, Seen const& seen, Add const& add) noexcept
{
    using namespace splat::detail;
    SetOf<Lanes> const set{};
    Rules const& m = w.rules;
    RowLimits const limits{m.alpha_min};
    std::uint32_t const left = tile.x0 / block_width * block_width, across = (tile.x1 - left + block_width - 1) / block_width;
    std::uint32_t const top = tile.y0 / block_height * block_height;
    std::uint32_t const blocks = across * ((tile.y1 - top + block_height - 1) / block_height);
    for (std::uint32_t next = worker.index; next < blocks;) {
        std::uint32_t open = 0;
        for (; open < Group && next < blocks; ++open, next += worker.count)
            memory.open[open].begin(left + next % across * block_width, top + next / across * block_height, next, tile, camera);
        for (std::uint32_t b = 0; b < open; ++b) std::memcpy(memory.walking[b].transmittance, memory.open[b].state.transmittance,
                                                             sizeof memory.walking[b].transmittance);
        // The first walk: the picture.
        through_chunks(
            set, memory, open, n, at, [](std::uint32_t, std::uint32_t) noexcept {},
            [&](std::uint32_t b, std::uint32_t const* hits, std::uint32_t part, std::uint32_t blended) noexcept {
                auto& block = memory.open[b];
                set.template call<BlendBlock<Stop>>(block.state, static_cast<Chunk<Size> const&>(memory.chunk), hits, part, block.at, m,
                                                    limits);
                return blended % blended_between_looks == 0 && all_stopped(block.state.transmittance, m.transmittance_min);
            },
            [](std::uint32_t, std::uint32_t) noexcept {});
        // The slopes.
        bool wanted = false;
        for (std::uint32_t b = 0; b < open; ++b) {
            BlockTarget of_block;
            BlockLoss loss;
            take_target(of_block, memory.open[b], tile, target, stride_px);
            set.template call<MakeSlopes>(static_cast<DepthBlockFields const&>(memory.open[b].state), of_block, m.background, w.loss,
                                          memory.walking[b].slopes, loss);
            wanted |= seen(memory.open[b], loss);
        }
        if (!wanted) continue;
        // The second walk: the sums.
        through_chunks(
            set, memory, open, n, at,
            [&](std::uint32_t begin, std::uint32_t count) noexcept {
                for (std::uint32_t i = 0; i < count; ++i) memory.chunk.prepare(i, at(begin + i), m.dilation, w.loss.limit);
            },
            [&](std::uint32_t b, std::uint32_t const* hits, std::uint32_t part, std::uint32_t blended) noexcept {
                set.template call<WalkBlock<Stop>>(memory.walking[b], memory.chunk, hits, part, memory.open[b].at, m, w.loss);
                return blended % blended_between_looks == 0 && all_stopped(memory.walking[b].transmittance, m.transmittance_min);
            },
            [&](std::uint32_t begin, std::uint32_t count) noexcept {
                for (std::uint32_t i = 0; i < count; ++i)
                    if (auto const one = memory.chunk.sums_of(i); !one.empty()) add(begin + i, one);
            });
    }
}
} // namespace detail

/// Blends n splats, `at(0)` to `at(n - 1)` from front to back, into the pixels of `tile` with `precise` arithmetic, compares the picture
/// with a target, and walks through the splats again. Pixel (x, y) of the target is `target[(y - tile.y0) * stride_px + x - tile.x0]`.
///
/// `seen(block, loss)` gets each blended block, without the background, and its loss; it returns whether the sums are wanted. `add(i,
/// sums)` gets sums of splat i that are not all 0, one or more times: they are to be added. If the tile consists of whole blocks
/// (`has_whole_blocks`), the totals over all tiles of a frame do not depend on the tiling, the workers, or the lanes. `worker` takes
/// every count-th block.
///
/// Cost: 80 pairs of each walk for each splat that a block may see before all of its pixels have stopped. A pair of the second walk takes
/// about 2.5 times as long as one of the first.
template <std::uint32_t Lanes = splat::detail::native_lanes, std::uint32_t Group, std::uint32_t Size, class SplatAt, class Seen, class Add>
void walk_tile(WalkMemory<Group, Size>& memory, PixelRect const& tile, Camera const& camera, WalkRules const& w, std::uint32_t n,
               SplatAt const& at,
               TargetPixel const* target, std::uint32_t stride_px, Worker worker, Seen const& seen, Add const& add) noexcept
{
    if (tile.empty()) return;
    if (w.rules.stop == Stop::after_crossing)
        detail::walk_tile_by<splat::detail::StopEachPixel, Lanes>(memory, tile, camera, w, n, at, target, stride_px, worker, seen, add);
    else
        detail::walk_tile_by<splat::detail::StopBeforeCrossing, Lanes>(memory, tile, camera, w, n, at, target, stride_px, worker, seen,
                                                                       add);
}
/// `walk_tile` for all workers of a tile, by one host thread.
template <std::uint32_t Lanes = splat::detail::lanes_in_use, std::uint32_t Group, std::uint32_t Size, class SplatAt, class Seen, class Add>
void walk_whole_tile(WalkMemory<Group, Size>& memory, PixelRect const& tile, Camera const& camera, WalkRules const& w, std::uint32_t n,
                     SplatAt const& at, TargetPixel const* target, std::uint32_t stride_px, Seen const& seen, Add const& add) noexcept
{
    walk_tile<Lanes>(memory, tile, camera, w, n, at, target, stride_px, Worker{0, 1}, seen, add);
}

}}} // namespace tilemesh::splat::map
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
