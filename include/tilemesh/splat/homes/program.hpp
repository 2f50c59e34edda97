#pragma once
#include <tilemesh/machine/superstep.hpp>
#include <tilemesh/splat/homes/blend.hpp>
#include <tilemesh/splat/homes/deliver.hpp>
#include <tilemesh/splat/homes/tell.hpp>

/// The program of homes and windows, and its kernels that send nothing.
namespace tilemesh { inline namespace v0_2 { namespace splat::homes {

/// Projects the records of a home. All workers share them. No copy is ever projected.
template <class P>
struct Project {
    static constexpr char const* name = "project";
    using FrameParameters = typename P::Parameters;
    void operator()(Broadcast<FrameParameters> frame, Home<P> const& home, Seen<P>& seen, Worker worker) const noexcept
    {
        for (std::uint32_t i = worker.index, n = home.size(); i < n; i += worker.count)
            seen[i] = splat::Access<FrameParameters>::project(home[i], *frame);
    }
    /// For a cost model. All workers wait for the one with the most records.
    static Operations operations(Broadcast<FrameParameters> frame, Home<P> const& home, Worker worker) noexcept
    {
        Operations o;
        o[Operation::projection] = projections_through(frame->view.camera, (home.size() + worker.count - 1) / worker.count);
        return o;
    }
};

namespace detail {
/// Ends the window at the first cut behind its beginning; without such a cut it has no end.
TILEMESH_KERNEL void open_window(Window& window, Cuts const& cuts) noexcept
{
    window.hi_depth = infinite_depth;
    for (std::uint32_t const cut : cuts)
        if (cut > window.lo_depth) {
            window.hi_depth = cut;
            break;
        }
    window.frontier_depth = window.hi_depth;
    window.frontier_id = 0;
    window.seen = 0;
    window.stride = 1;
}

/// A tile with at least so many windows to come, or behind it, is a crowd. A map has one where it is seen from far away (bench/any_map).
inline constexpr std::uint32_t crowd_windows = 8;

/// Makes cuts of a sample of the depths that a window refused, so that about `each` splats lie between two of them.
///
/// In a crowd the new cuts go before those behind the window, which stay. Otherwise the window after the last new cut would have no end,
/// and every home would send again all that is left. If there is no room for all new cuts, they lie further apart, and their windows are
/// cut again when they refuse. So n splats of different depths on one tile arrive n log n times at most. For more splats of one depth than
/// the tile holds it is n^2 / (2 * `each`): a notice has no ids, so no cut parts them, and each round brings all that are left.
inline void cut_refused(Window const& window, Sample& sample, Cuts& cuts, std::uint32_t each) noexcept
{
    splat::detail::heap_sort(sample.begin(), sample.size());
    std::uint32_t apart = each / window.stride > 0 ? each / window.stride : 1;
    std::uint32_t behind[most_cuts] = {}, n = 0;
    for (std::uint32_t const cut : cuts)
        if (cut >= window.hi_depth) behind[n++] = cut;
    if (n < crowd_windows && (window.blended + window.seen) / crowd_windows <= each) {
        n = 0;
    } else {
        std::uint32_t const wanted = sample.size() > 0 ? (sample.size() - 1) / apart : 0;
        if (n > most_cuts / 2 && n + wanted > most_cuts) { // every second one goes
            for (std::uint32_t i = 0; 2 * i < n; ++i) behind[i] = behind[2 * i];
            n = (n + 1) / 2;
        }
        // A quarter of the room stays free for windows that must be cut again.
        std::uint32_t const room = most_cuts - n;
        if (wanted > room) apart = (sample.size() - 1) / (room - room / 4) + 1;
    }
    cuts.truncate(0);
    for (std::uint32_t i = apart; i < sample.size() && cuts.size() + n < most_cuts; i += apart) cuts.push(sample[i]);
    for (std::uint32_t i = 0; i < n; ++i) cuts.push(behind[i]);
}
} // namespace detail

/// Begins a picture on a tile: black pixels, and a window from the nearest depth to the first cut of the last frame. In a later chapter the
/// pixels stay, and a tile whose blocks have all stopped stays done. Votes busy if the tile wants splats.
template <class P>
struct Begin {
    static constexpr char const* name = "begin";
    using FrameParameters = typename P::Parameters;
    Vote operator()(Here here, Broadcast<FrameParameters> frame, Seen<P> const& seen, Window& window, Held<P>& held, Keys& keys, Order& order,
                    Cuts& cuts, NextCuts& next_cuts, Sample& sample, BlocksOf<P>& blocks, Counts& counts, Work& work) const noexcept
    {
        counts = {};
        work = {};
        for (auto const& entry : seen) counts.visible += splat::Access<FrameParameters>::splat_of(*frame, entry).visible() ? 1u : 0u;
        held.truncate(0);
        keys.truncate(0);
        order.truncate(0);
        sample.truncate(0);
        bool const goes_on = frame->chapter_depth != 0;
        if (!goes_on) {
            cuts.truncate(0);
            for (std::uint32_t const cut : next_cuts) cuts.push(cut);
            next_cuts.truncate(0);
        }
        std::uint32_t const finished = goes_on ? window.finished : 0, blended = goes_on ? window.blended : 0;
        window = {};
        if (!has_blocks(here, frame->fold)) {
            window.lo_depth = infinite_depth;
            return Vote::quiet;
        }
        window.lo_depth = frame->chapter_depth;
        window.finished = finished;
        window.blended = blended;
        if (!goes_on) {
            blocks.resize(frame->fold.tile_blocks());
            machine::in_form(machine::is_wide(*frame), blocks.begin(), [&](auto* kept) noexcept {
                for (std::uint32_t b = 0; b < blocks.size(); ++b) {
                    auto const place = block_at(frame->fold, here.tile, b);
                    detail::begin_block(kept[b], place, frame->view.camera);
                    if (!place.exists && frame->fold.blocks_a_bit == 1) window.finished |= frame->fold.bit_of(b);
                }
            });
        } else if (window.finished == 0xffffffffu) {
            window.lo_depth = infinite_depth;
            return Vote::quiet;
        }
        detail::open_window(window, cuts);
        return Vote::busy;
    }
    static Operations operations(Seen<P> const& seen, BlocksOf<P> const& blocks) noexcept
    {
        Operations o;
        o[Operation::slot] = seen.size();
        o[Operation::pixel] = blocks.size() * block_width * block_height;
        return o;
    }
};

/// Goes on behind the splats that are blended: the window begins at the frontier. A tile is done if its blocks have stopped, or if nothing is
/// behind the frontier. Votes busy unless the tile is done.
///
/// Cuts. Every 0.9 K-th splat that a tile blends, of K that it can hold, is a cut of the next frame; a tile that blends at most 0.95 K needs
/// none. If the tile had to refuse splats, the depths of a sample of them are the cuts of this frame's next rounds, 0.8 K apart (`cut_refused`).
/// Cuts change the number of rounds, never the picture.
template <class P>
struct Advance {
    static constexpr char const* name = "advance";
    using FrameParameters = typename P::Parameters;
    Vote operator()(Broadcast<FrameParameters> frame, Window& window, Held<P>& held, Keys& keys, Order& order, Cuts& cuts,
                    NextCuts& next_cuts, Sample& sample, BlocksOf<P> const& blocks, Counts& counts) const noexcept
    {
        if (window.done()) return Vote::quiet;
        ++counts.rounds;
        std::uint32_t const n = keys.size(), capacity = held.capacity();
        std::uint32_t const each = share(capacity, 9);
        for (std::uint32_t i = each - 1 - window.blended % each; i < n && next_cuts.size() < most_cuts; i += each)
            next_cuts.push(keys[order[i]].depth_key + 1);
        window.blended += n;
        held.truncate(0);
        keys.truncate(0);
        order.truncate(0);

        auto const& rules = frame->view.rules;
        std::uint32_t going = 0; // a bit is finished if none of its blocks goes on
        machine::in_form(machine::is_wide(*frame), blocks.begin(), [&](auto const* kept) noexcept {
            for (std::uint32_t b = 0; b < blocks.size(); ++b)
                if (detail::going_strips(kept[b], (1u << detail::strips_a_block) - 1, rules.transmittance_min) != 0) going |= frame->fold.bit_of(b);
        });
        window.finished = ~going;

        if (window.refused()) detail::cut_refused(window, sample, cuts, share(capacity, 8));
        sample.truncate(0);
        (void)TILEMESH_EXPECT((Key{window.lo_depth, window.lo_id} < Key{window.frontier_depth, window.frontier_id}),
                              "a window that does not move (the protocol of homes is broken); report this");
        window.lo_depth = window.frontier_depth;
        window.lo_id = window.frontier_id;
        if (going == 0) window.lo_depth = infinite_depth;
        if (window.done()) {
            if (window.blended <= share(capacity, 9) + capacity / 20) next_cuts.truncate(0); // one window is enough
            return Vote::quiet;
        }
        detail::open_window(window, cuts);
        return Vote::busy;
    }
    static Operations operations(BlocksOf<P> const& blocks) noexcept
    {
        Operations o;
        o[Operation::pixel] = blocks.size(); // a look at the transmittance of a block: 80 words, about the work of a pixel's blending state
        return o;
    }

private:
    /// tenths / 10 of n, at least 1.
    TILEMESH_KERNEL static std::uint32_t share(std::uint32_t n, std::uint32_t tenths) noexcept
    {
        std::uint32_t const s = n / 10 * tenths + n % 10 * tenths / 10;
        return s > 0 ? s : 1;
    }
};

/// Makes the pixels that the host reads, on the background. All workers share the blocks. The blocks stay as they are, because a later
/// chapter goes on with them.
template <class P>
struct Finish {
    static constexpr char const* name = "finish";
    using FrameParameters = typename P::Parameters;
    void operator()(Broadcast<FrameParameters> frame, BlocksOf<P> const& blocks, Framebuffer<typename P::Pixel>& framebuffer,
                    Worker worker) const noexcept
    {
        auto const& background = frame->view.rules.background;
        bool const wide = machine::is_wide(*frame);
        machine::in_form(wide, blocks.begin(), [&](auto const* kept) noexcept {
            machine::in_form(wide, framebuffer.begin(), [&](auto* all_pixels) noexcept {
                for (std::uint32_t b = worker.index; b < blocks.size(); b += worker.count) {
                    auto* const pixels = all_pixels + b * block_height * block_width;
                    if (is_black(background)) {
                        make_pixels(kept[b], pixels);
                    } else {
                        auto shown = kept[b];
                        detail::add_background(shown, background);
                        make_pixels(shown, pixels);
                    }
                }
            });
        });
    }
    static Operations operations(Framebuffer<typename P::Pixel> const& framebuffer) noexcept
    {
        Operations o;
        o[Operation::pixel] = framebuffer.size();
        return o;
    }

private:
    template <class Block, class Pixel>
    TILEMESH_KERNEL static void make_pixels(Block const& block, Pixel* pixels) noexcept
    {
        if constexpr (splat::Access<FrameParameters>::on_host && std::is_same_v<Pixel, FloatPixel>) {
            for (std::uint32_t j = 0; j < block_height; ++j)
                for (std::uint32_t i = 0; i < block_width; i += 4)
                    detail::store_interleaved(pixels[j * block_width + i].rgb, block.red[j] + i, block.green[j] + i, block.blue[j] + i);
            return;
        }
        for (std::uint32_t j = 0; j < block_height; ++j)
            for (std::uint32_t i = 0; i < block_width; ++i) pixels[j * block_width + i] = Pixel::make(detail::blended(block, j, i));
    }
};

/// One round: every tile learns all windows, homes find out what is wanted and deliver it, and the tiles blend it and go on. The first pass
/// of Deliver runs on every tile, because nobody votes before it.
template <class P>
using Rounds = Loop<Repeat<Tell<P>>, Superstep<Offer<P>>, Superstep<Deliver<P>>, UntilQuiet<Deliver<P>>, Superstep<SortRuns<P>>,
                    Superstep<Merge<P>>, Superstep<Blend<P>>, Superstep<Advance<P>>>;

/// One frame, or one chapter of it. The host puts the records onto their homes once, and sizes `Seen`, `Offers`, `Table` and `Framebuffer`.
///
/// The picture is that of one list in depth order for the whole frame, bit for bit, for any capacity of at least 1. When Deliver is quiet, a
/// tile has been offered every splat of its window that an unfinished block may see, and every refused key is at or behind the frontier,
/// which is behind all held keys. So it blends exactly the wanted keys from lo to the frontier, in order, and the next round begins there.
/// A splat that is refused has touched no pixel; a splat that is not sent would change none.
///
/// It ends: a tile that is not done either empties its window (then lo moves to a cut, of which there are finitely many, then to infinity)
/// or blends at least one splat.
template <class P>
using Frame = Sequence<Superstep<Project<P>>, Superstep<Begin<P>>, Rounds<P>, Superstep<Finish<P>>>;

/// Bounds the rounds of a frame. A tile that a bound leaves unfinished shows the nearest splats, exactly.
template <class P>
void bound_rounds(Frame<P>& frame, std::uint32_t rounds) noexcept
{
    get_loop<Blend<P>>(frame).at_most = rounds;
}
/// The frame program for a grid.
template <class P>
Frame<P> frame_program(Grid grid)
{
    Frame<P> frame;
    get_step<Tell<P>>(frame).times = tell_passes(grid.width, grid.height);
    return frame;
}

}}} // namespace tilemesh::splat::homes
