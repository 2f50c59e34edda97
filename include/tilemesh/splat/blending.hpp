#pragma once
#include <tilemesh/machine/either.hpp>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/splat/blending_block.hpp>
#include <tilemesh/splat/cell_tiles.hpp>
#include <tilemesh/splat/policies.hpp>

/// Blends a list of splats, front to back, into a rectangle of pixels. A tile does this with its sorted splats; a rasteriser without tiles
/// needs nothing else.
///
/// `precise` arithmetic blends blocks of 16 x 5 pixels. 16 x 5 divides the paper's 32 x 20 tile, and the 20 vectors of a block's state stay in
/// registers on a target with 32 registers of 16 lanes. A block goes through the splats in chunks. A test over `Lanes` splats at once finds
/// the splats that a pixel of the block may see. These splats are blended one after the other into the 5 rows.
///
/// `fast` arithmetic blends cells of 8 x 4 pixels (cell_tiles.hpp). A cell blends the splats whose ellipse at the cut reaches it.
///
/// Blocks and cells lie on the frame's pixel grid, whatever the tiling is: one that a tile border cuts is evaluated whole and masked.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace detail {
/// `blend_tile` in blocks, `Group` blocks at a time. `counts[number % workers]` gets the pairs of block `number`.
template <class Stop, std::uint32_t N, std::uint32_t Group, std::uint32_t Size, class Pixel, class SplatAt>
void blend_tile_in_blocks(PixelRect const& tile, Camera const& camera, Rules const& rules, std::uint32_t n, SplatAt const& at,
                          Pixel* pixels, std::uint32_t stride_px, Worker worker, PairCount* counts, std::uint32_t workers) noexcept
{
    static_assert(block_width * block_height % pairs_a_count == 0, "pairs are counted in whole units");
    RowLimits const limits{rules.alpha_min};
    SetOf<N> const set{};
    bool const has_background = !is_black(rules.background);
    OpenBlock<Pixel::has_depth> group[Group];
    Chunk<Size> chunk;
    std::uint32_t hits[Size + SetOf<N>::most_lanes];
    std::uint32_t const left = tile.x0 / block_width * block_width;
    std::uint32_t const across = (tile.x1 - left + block_width - 1) / block_width;
    std::uint32_t const top = tile.y0 / block_height * block_height;
    std::uint32_t const blocks = across * ((tile.y1 - top + block_height - 1) / block_height);

    for (std::uint32_t next = worker.index; next < blocks;) {
        fetch_ahead(0, n < Size ? n : Size, at);
        std::uint32_t open = 0;
        for (; open < Group && next < blocks; ++open, next += worker.count)
            group[open].begin(left + next % across * block_width, top + next / across * block_height, next, tile, camera);
        for (std::uint32_t b = 0; b < open; ++b)
            for (std::uint32_t y = group[b].live.y0; y < group[b].live.y1; ++y)
                fetch_row_ahead(pixels + (y - tile.y0) * stride_px, group[b].live.x0 - tile.x0, group[b].live.x1 - tile.x0);
        std::uint32_t going = open;
        for (std::uint32_t begin = 0; begin < n && going != 0; begin += Size) {
            std::uint32_t const most = fill(set, chunk, begin, n, at);
            for (std::uint32_t b = 0; b < open; ++b) {
                auto& block = group[b];
                fetch_part_ahead<Size>(begin + Size, n, b, open, at);
                if (block.done) continue;
                std::uint32_t const count = set.template call<ListHits>(chunk, most, block.at, &hits[0]);
                auto& pairs = counts[block.number % workers];
                for (std::uint32_t done = 0; done < count && !block.done;) {
                    std::uint32_t part = blended_between_looks - block.blended % blended_between_looks;
                    if (part > count - done) part = count - done;
                    pairs.contributing += set.template call<BlendBlock<Stop>>(block.state, chunk, hits + done, part, block.at, rules, limits);
                    pairs.evaluated += part * (block_width * block_height / pairs_a_count);
                    done += part;
                    block.blended += part;
                    if (block.blended % blended_between_looks == 0 && finished(block.state, rules.transmittance_min))
                        block.done = true, --going;
                }
            }
        }
        for (std::uint32_t b = 0; b < open; ++b) {
            auto& block = group[b];
            auto const& live = block.live;
            if (has_background) add_background(block.state, rules.background);
            std::uint32_t const skip = live.x0 - static_cast<std::uint32_t>(block.at.column);
            for (std::uint32_t y = live.y0; y < live.y1; ++y) {
                std::uint32_t const row = y - static_cast<std::uint32_t>(block.at.row);
                Pixel* const to = pixels + (y - tile.y0) * stride_px + (live.x0 - tile.x0);
                if (live.x1 - live.x0 == block_width) { // almost always: a loop of constant length
                    for (std::uint32_t i = 0; i < block_width; ++i) to[i] = Pixel::make(blended(block.state, row, i));
                } else {
                    for (std::uint32_t i = 0; i < live.x1 - live.x0; ++i)
                        to[i] = Pixel::make(blended(block.state, row, skip + i));
                }
            }
        }
    }
}

/// `blend_tile` with one arithmetic. At most `Cells` cells are open at once, or a quarter as many blocks.
template <class Rule, class Stop, std::uint32_t N, std::uint32_t Cells, std::uint32_t Size, class Pixel, class SplatAt>
[[gnu::noinline]] void blend_tile_by(PixelRect const& tile, Camera const& camera, Rules const& rules, std::uint32_t n, SplatAt const& at,
                                     Pixel* pixels, std::uint32_t stride_px, Worker worker, PairCount* counts, std::uint32_t workers) noexcept
{
    if constexpr (Rule::in_cells) {
        CellMemory<Pixel::has_depth, Cells, Size> memory;
        blend_tile_in_cells<Rule, Stop, N>(memory, tile, camera, rules, n, at, pixels, stride_px, worker, counts, workers);
    } else {
        blend_tile_in_blocks<Stop, N, (Cells + 3) / 4, Size>(tile, camera, rules, n, at, pixels, stride_px, worker, counts, workers);
    }
}

/// `blend_tile_by` with the arithmetic and the stop that the rules ask for. It is called, not inlined: a compiler would decide that by
/// what else stands in the unit, and a unit's code is to be the same beside code that it does without (tests/checks/leave_out.sh).
template <std::uint32_t N, std::uint32_t Cells, std::uint32_t Size, class Pixel, class SplatAt>
[[gnu::noinline]] void blend_tile_as_asked(PixelRect const& tile, Camera const& camera, Rules const& rules, std::uint32_t n, SplatAt const& at,
                         Pixel* pixels, std::uint32_t stride_px, Worker worker, PairCount* counts, std::uint32_t workers) noexcept
{
    if (tile.empty()) return;
    bool const each = rules.arithmetic == Arithmetic::precise || !(rules.alpha_min >= faintest_cut);
    if (rules.stop == Stop::after_crossing && each)
        blend_tile_by<EachPair, StopEachPixel, N, Cells, Size>(tile, camera, rules, n, at, pixels, stride_px, worker, counts, workers);
    else if (each)
        blend_tile_by<EachPair, StopBeforeCrossing, N, Cells, Size>(tile, camera, rules, n, at, pixels, stride_px, worker, counts, workers);
    else
        blend_tile_by<FastRule, StopAsAsked, N, Cells, Size>(tile, camera, rules, n, at, pixels, stride_px, worker, counts, workers);
}
} // namespace detail

/// Blends n splats, `at(0)` to `at(n - 1)` from front to back, into the pixels of `tile`.
/// Pixel (x, y) is `pixels[(y - tile.y0) * stride_px + x - tile.x0]`. A pixel blends, then tests: C += w c and T -= w with w = alpha T,
/// until T < transmittance_min. With Stop::before_crossing it tests first: the term that would leave less than the limit ends the pixel.
/// The pixel is C + T background.
///
/// `precise` arithmetic is bit-identical to the naive per-pixel loop over the whole frame, for any tiling and any `Lanes`. `fast` differs
/// from it by at most 2e-5 of alpha (tests/splat/blending.cpp), and its bits do not depend on tiling or lanes. `worker` takes every
/// count-th block or cell, so that workers write disjoint pixels.
///
/// Cost: 80 pairs (`precise`) or 32 pairs (`fast`) for each splat that a block or a cell may see before all of its pixels have stopped; about
/// 5 KiB of stack.
template <std::uint32_t Lanes = detail::native_lanes, class Pixel, class SplatAt>
PairCount blend_tile(PixelRect const& tile, Camera const& camera, Rules const& rules, std::uint32_t n, SplatAt const& at,
                     Pixel* pixels, std::uint32_t stride_px, Worker worker) noexcept
{
    PairCount pairs{};
    detail::blend_tile_as_asked<Lanes, 2, 16>(tile, camera, rules, n, at, pixels, stride_px, worker, &pairs, 1);
    return pairs;
}

/// `blend_tile` for all workers of a tile, by one host thread. `counts[w]` gets the counts of worker w of `workers`. It goes through the
/// splats once for 8 blocks or 32 cells: one or more of the paper's tiles. Cost: 22 KiB of stack (`precise`), 50 KiB (`fast`; 58 KiB with depth).
template <std::uint32_t Lanes = detail::lanes_in_use, class Pixel, class SplatAt>
void blend_whole_tile(PixelRect const& tile, Camera const& camera, Rules const& rules, std::uint32_t n, SplatAt const& at,
                      Pixel* pixels, std::uint32_t stride_px, PairCount* counts, std::uint32_t workers) noexcept
{
    detail::blend_tile_as_asked<Lanes, 32, 128>(tile, camera, rules, n, at, pixels, stride_px, Worker{0, 1}, counts, workers);
}

/// The blending that Composite uses. A setup may name another one (`S::Blending`). `tile` blends one worker's share, `whole` blends all
/// shares on one host thread. `frame` holds the frame's parameters, which the host sent to the tiles. In the compiled library, blending by
/// reference is compiled once (render/host_form.hpp).
struct BlendAsAsked {
    template <class Frame, class SplatAt, class Pixel>
    TILEMESH_KERNEL static PairCount tile(PixelRect const& tile, Frame const& frame, std::uint32_t n, SplatAt const& at, Pixel* pixels,
                          std::uint32_t stride_px, Worker worker) noexcept
    {
        return machine::in_form(machine::is_wide(frame), pixels, [&](auto* to) noexcept {
            return blend_tile(tile, frame.view.camera, frame.view.rules, n, at, to, stride_px, worker);
        });
    }
    template <class Frame, class SplatAt, class Pixel>
    TILEMESH_KERNEL static void whole(PixelRect const& tile, Frame const& frame, std::uint32_t n, SplatAt const& at, Pixel* pixels,
                      std::uint32_t stride_px, PairCount* counts, std::uint32_t workers) noexcept
    {
        machine::in_form(machine::is_wide(frame), pixels, [&](auto* to) noexcept {
            blend_whole_tile(tile, frame.view.camera, frame.view.rules, n, at, to, stride_px, counts, workers);
        });
    }
};

}}} // namespace tilemesh::splat
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
