#pragma once
#include <cstdint>
#include <initializer_list>
#include <tilemesh/splat/frame_program.hpp>

/// Load balance: a tile lends rows of its blocks to neighbours that have less to blend. They blend them and send the pixels back.
///
/// A *strip* is a row of blocks across the tile (of cells with `fast` arithmetic). The *load* of a tile is the largest number of pairs of a
/// splat and a block that one of its workers has, by the rectangles of the splats. After the depth sort:
///   1. `TellLoad`: each tile tells its load to its four neighbours.
///   2. `OfferHelp`: a tile offers its help to the neighbour with the largest load, if its own is smaller.
///   3. `LendStrips`: a tile with offers chooses strips at its upper or lower border, at most one for each helper, while the larger load
///      of the two becomes smaller than its own was. It sends the splats of the strip in depth order. The helper keeps them in the free
///      slots of its own list.
///   4. `CompositeLending`: both blend, with the same operations for each pixel.
///   5. `ReturnPixels`: the helper sends the pixels back.
/// A tile helps at most one neighbour. It may lend in the same frame. A strip for which a helper has no room stays at home. Every rule is
/// in integers, and needs only words of the tile and of its four neighbours. No capacity changes a pixel, a record's tile, or the number
/// of pairs: a channel with one slot takes more passes.
namespace tilemesh { inline namespace v0_2 { namespace splat {

template <class S>
struct LendingSteps;

/// The blending of a setup that lends strips: `struct Mine : splat::Lossless { using Blending = splat::LendsStrips<>; ... };`. The setup
/// has pixels whose type on the host is that of the machine, as FloatPixel. A setup without it has none of the steps, channels and states.
///
/// `Splats`, `Pixels`: messages in an end of the two channels. `StripPixels`: the pixels of the largest strip that a tile takes. Cost: 8 *
/// (8 + 56 * Splats) + 8 * (8 + 12 * Pixels) + 12 * StripPixels + 824 bytes of SRAM; in every frame, also of a view that stays, two
/// exchanges of 16 bytes, and the passes that carry splats and pixels.
template <std::uint32_t Splats = 32, std::uint32_t Pixels = 64, std::uint32_t StripPixels = 160>
struct LendsStrips : BlendAsAsked {
    static constexpr std::uint32_t splat_slots = Splats, pixel_slots = Pixels, strip_pixels = StripPixels;
    static_assert(Splats >= 1 && Pixels >= 1, "a channel of lent blocks without a slot (nothing goes through it); give it at least one");
    template <class S>
    using Steps = LendingSteps<S>;
};

/// `Lossless` with lent strips. Its storage has fewer slots, so that channels and buffers of lending fit into the SRAM of Mk2.
struct LosslessLending : Lossless {
    static constexpr char const* name = "lossless, lending";
    using Blending = LendsStrips<>;
    static constexpr Sizes sizes{/*storage*/ 1840, Lossless::sizes.road, Lossless::sizes.beam, Lossless::sizes.waiting,
                                 Lossless::sizes.tile_pixels};
};

// --- what a tile has to blend ------------------------------------------------------------------------------------------------

/// The blocks of a tile, strip by strip.
struct BlockGrid {
    static constexpr std::uint32_t most_blocks = 64; ///< a tile with more takes no part
    PixelRect tile;
    std::uint32_t width, height; ///< of a block
    std::uint32_t left, top;     ///< of the first block
    std::uint32_t across, strips;

    BlockGrid(PixelRect const& pixels, Rules const& rules) noexcept : tile(pixels)
    {
        bool const cells = rules.arithmetic == Arithmetic::fast;
        width = cells ? cell_width : block_width;
        height = cells ? cell_height : block_height;
        left = tile.x0 / width * width;
        top = tile.y0 / height * height;
        across = tile.empty() ? 0 : (tile.x1 - left + width - 1) / width;
        strips = tile.empty() ? 0 : (tile.y1 - top + height - 1) / height;
    }
    bool takes_part() const noexcept { return strips != 0 && strips <= most_blocks && across <= most_blocks / strips; }
    /// The pixels of the strips [first, last).
    PixelRect rect(std::uint32_t first, std::uint32_t last) const noexcept
    {
        std::uint32_t const y0 = top + first * height, y1 = top + last * height;
        return {tile.x0, tile.x1, y0 > tile.y0 ? y0 : tile.y0, y1 < tile.y1 ? y1 : tile.y1};
    }
    /// Strips or columns of blocks from `first` to the one before `last`; none if `first` is not below `last`.
    struct Range {
        std::uint32_t first, last;
    };
    static Range range(std::uint32_t s0, std::uint32_t s1, std::uint32_t t0, std::uint32_t t1, std::uint32_t origin,
                       std::uint32_t size) noexcept
    {
        std::uint32_t const from = s0 > t0 ? s0 : t0, to = s1 < t1 ? s1 : t1;
        if (from >= to) return {0, 0};
        return {(from - origin) / size, (to - 1 - origin) / size + 1};
    }
    /// The strips that a splat's rectangle touches.
    Range strips_of(Splat const& s) const noexcept
    {
        auto const r = s.rect();
        if (columns_of(s).last == 0) return {0, 0};
        return range(r.y0, r.y1, tile.y0, tile.y1, top, height);
    }
    Range columns_of(Splat const& s) const noexcept
    {
        auto const r = s.rect();
        return range(r.x0, r.x1, tile.x0, tile.x1, left, width);
    }
};

/// The pairs of a splat and a block that each worker of a tile has.
struct WorkerLoads {
    /// The workers among which blocks are shared out in the prediction: those of the IPU. A machine with others gets the same pixels.
    static constexpr std::uint32_t workers = 6;
    std::uint32_t of[workers];

    std::uint32_t most() const noexcept
    {
        std::uint32_t most = 0;
        for (std::uint32_t load : of) most = load > most ? load : most;
        return most;
    }
    /// The most of worker `first` and those after it, `n` in all.
    std::uint32_t most_of(std::uint32_t first, std::uint32_t n) const noexcept
    {
        std::uint32_t most = 0;
        for (std::uint32_t i = 0; i < n && i < workers; ++i) {
            std::uint32_t const load = of[(first + i) % workers];
            most = load > most ? load : most;
        }
        return most;
    }
    /// The worker from which on `n` have least: they get the blocks of a guest.
    std::uint32_t least(std::uint32_t n) const noexcept
    {
        std::uint32_t best = 0;
        for (std::uint32_t w = 1; w < workers; ++w)
            if (most_of(w, n) < most_of(best, n)) best = w;
        return best;
    }
};

/// How many splats may touch each block and each strip of a tile, by their rectangles.
struct BlockCounts {
    static constexpr char const* name = "splats of blocks";
    std::uint32_t hits[BlockGrid::most_blocks], splats[BlockGrid::most_blocks];
};
/// The same, with the blocks.
struct BlockLoads : BlockCounts {
    BlockGrid grid;

    /// Requires a grid that takes part.
    explicit BlockLoads(BlockGrid const& g, BlockCounts const& counts = {}) noexcept : BlockCounts(counts), grid(g) {}

    void add(Splat const& s) noexcept
    {
        auto const rows = grid.strips_of(s), columns = grid.columns_of(s);
        for (std::uint32_t y = rows.first; y < rows.last; ++y) {
            ++splats[y];
            for (std::uint32_t x = columns.first; x < columns.last; ++x) ++hits[y * grid.across + x];
        }
    }
    /// The load of a tile that blends the strips [first, last): blocks go to the workers in turn.
    WorkerLoads load(std::uint32_t first, std::uint32_t last) const noexcept
    {
        WorkerLoads loads{};
        for (std::uint32_t i = first * grid.across, w = 0; i < last * grid.across; ++i, w = w + 1 == WorkerLoads::workers ? 0 : w + 1)
            loads.of[w] += hits[i];
        return loads;
    }
    /// The pairs of the fullest block of a strip.
    std::uint32_t fullest(std::uint32_t strip) const noexcept
    {
        std::uint32_t most = 0;
        for (std::uint32_t x = 0; x < grid.across; ++x) most = hits[strip * grid.across + x] > most ? hits[strip * grid.across + x] : most;
        return most;
    }
};

// --- messages, channels and state --------------------------------------------------------------------------------------------

/// A tile's load. In an offer, also that of the workers who would get the blocks of a guest, and the splats and pixels for which it has
/// room.
struct LoadNotice {
    std::uint32_t load, beside, splats, pixels;
};
struct LoadNotices : Channel<LoadNotice, 1> {
    static constexpr char const* name = "loads";
};

/// A splat of a lent strip; a host moves its row.
template <class Projected>
struct LentSplat {
    static constexpr std::uint32_t wire_bytes = sizeof(Splat);
    Projected entry;
};
namespace region {
/// The note of each pass is the number of the strip in its own tile, plus 1.
template <class P>
struct LentSplats : Channel<LentSplat<typename P::Projected>, P::Blending::splat_slots> {
    static constexpr char const* name = "lent splats";
};
template <class P>
struct LentPixels : Channel<typename P::Pixel, P::Blending::pixel_slots> {
    static constexpr char const* name = "lent pixels";
};
/// The pixels of the strip that a tile blends for a neighbour.
template <class P>
struct GuestPixels : Buffer<typename P::Pixel, P::Blending::strip_pixels> {
    static constexpr char const* name = "pixels of a neighbour";
};
} // namespace region
template <class S>
using LentSplats = region::LentSplats<PoliciesOf<S>>;
template <class S>
using LentPixels = region::LentPixels<PoliciesOf<S>>;
template <class S>
using GuestPixels = region::GuestPixels<PoliciesOf<S>>;

/// What a tile lends and takes in this frame.
struct LentStrips {
    static constexpr char const* name = "lent strips";
    WorkerLoads loads;           ///< of its own blocks
    std::uint32_t first, last;   ///< the strips that the tile blends itself
    std::uint32_t across;        ///< blocks of a strip
    std::uint32_t alone;         ///< 1: it takes no part, because it has too many blocks
    std::uint32_t strip[4];      ///< by sides: the lent strip plus 1; 0: none
    std::uint32_t next[4];       ///< by sides: the key from which to go on sending
    std::uint32_t back[4];       ///< by sides: the pixels that are back
    std::uint32_t guest;         ///< the strip of a neighbour that it blends, plus 1; 0: none
    std::uint32_t side;          ///< of that neighbour, as index(d)
    std::uint32_t turn;          ///< the worker that gets the first block of the neighbour's
    std::uint32_t guest_splats;  ///< the first of its splats in the tile's list
    std::uint32_t sent;          ///< pixels that are on their way back
};

/// The keys at which a pass of `LendStrips` looked to send splats, and the blocks to choose strips.
struct LookedAt {
    static constexpr char const* name = "keys looked at";
    static constexpr bool per_pass = true;
    std::uint32_t slots;
};

namespace detail {
/// The blocks of a neighbour's tile.
template <class Frame>
BlockGrid blocks_of(Frame const& frame, TileId tile) noexcept
{
    return {pixels_of(frame.tiling, frame.view.camera, tile), frame.view.rules};
}

/// The offers of a tile's neighbours, by sides; no room: no offer.
struct Offers {
    LoadNotice of[4];
};
/// Chooses the strips that a tile lends: one to each neighbour that offers, the one with the smallest load first, as long as the larger
/// load of the two becomes smaller than the tile's was.
inline void choose_strips(BlockLoads const& loads, Offers offers, LentStrips& lent) noexcept
{
    for (std::uint32_t turn = 0; turn < 4; ++turn) {
        std::uint32_t side = 4;
        for (std::uint32_t d = 0; d < 4; ++d)
            if (offers.of[d].splats != 0 && (side == 4 || offers.of[d].load < offers.of[side].load)) side = d;
        if (side == 4 || lent.last - lent.first < 2) return;
        auto const offer = offers.of[side];
        offers.of[side].splats = 0;
        std::uint32_t least = loads.load(lent.first, lent.last).most(), chosen = lent.last;
        for (std::uint32_t const strip : {lent.last - 1, lent.first}) {
            bool const upper = strip == lent.first;
            auto const r = loads.grid.rect(strip, strip + 1);
            if (loads.splats[strip] == 0 || loads.splats[strip] > offer.splats || (r.x1 - r.x0) * (r.y1 - r.y0) > offer.pixels) continue;
            std::uint32_t const own = loads.load(lent.first + (upper ? 1 : 0), lent.last - (upper ? 0 : 1)).most();
            std::uint32_t const theirs = offer.beside + loads.fullest(strip), larger = own > theirs ? own : theirs;
            if (larger < least) least = larger, chosen = strip;
        }
        if (chosen == lent.last) continue;
        lent.strip[side] = chosen + 1;
        lent.next[side] = 0;
        (chosen == lent.first ? lent.first += 1 : lent.last -= 1);
        lent.loads = loads.load(lent.first, lent.last);
    }
}
} // namespace detail

namespace kernel {
template <class S>
struct TellLoad {
    static constexpr char const* name = "tell load";
    void operator()(Here here, Broadcast<typename S::Parameters> frame, Splats<S> const& splats, Order<S> const& order, LentStrips& lent,
                    BlockCounts& counts, Out<LoadNotices> out) const noexcept
    {
        auto const grid = detail::blocks_of(*frame, here.tile);
        lent = {};
        lent.last = grid.strips;
        lent.across = grid.across;
        if (grid.takes_part()) {
            BlockLoads loads(grid);
            auto const at = AccessOf<S>::in_order(*frame, splats.begin(), order.begin());
            for (std::uint32_t i = 0; i < order.size(); ++i) loads.add(at(i));
            lent.loads = loads.load(0, grid.strips);
            counts = loads;
        } else {
            lent.alone = grid.strips != 0 ? 1 : 0; // too many blocks: as one that has nothing to do, but it does not help
        }
        for (Direction d : news)
            if (here.grid.has_neighbour(here.tile, d)) out[d].unchecked_push({lent.loads.most(), 0, 0, 0});
    }
    /// For a cost model. To count a splat's blocks takes as many instructions as a comparison of two keys, about 30.
    static Operations operations(Order<S> const& order) noexcept
    {
        Operations o;
        o[Operation::comparison] = order.size();
        return o;
    }
};

template <class S>
struct OfferHelp {
    static constexpr char const* name = "offer help";
    void operator()(Storage<S> const& storage, GuestPixels<S> const& guest, LentStrips& lent, In<LoadNotices> in,
                    Out<LoadNotices> out) const noexcept
    {
        if (lent.alone != 0 || storage.room() == 0) return;
        std::uint32_t side = 4, most = 0;
        for (Direction d : news)
            if (!in[d].empty() && in[d][0].load > most) most = in[d][0].load, side = index(d);
        if (side == 4 || lent.loads.most() >= most) return;
        std::uint32_t const beside = lent.loads.most_of(lent.loads.least(lent.across), lent.across);
        out[news[side]].unchecked_push({lent.loads.most(), beside, storage.room(), guest.capacity()});
    }
    /// For a cost model.
    static Operations operations(In<LoadNotices> in) noexcept
    {
        Operations o;
        for (Direction d : news) o[Operation::slot] += in[d].size();
        return o;
    }
};

template <class S>
struct LendStrips {
    static constexpr char const* name = "lend";
    Vote operator()(Here here, Broadcast<typename S::Parameters> frame, Splats<S>& splats, Order<S> const& order, GuestPixels<S>& guest,
                    LentStrips& lent, BlockCounts const& counts, LookedAt& looked, In<LoadNotices> loads, In<LentSplats<S>> in,
                    Out<LentSplats<S>> out) const noexcept
    {
        // Take the splats of the neighbour that accepted.
        for (Direction d : news) {
            if (in[d].note() == 0) continue;
            if (lent.guest == 0) {
                lent.guest = in[d].note();
                lent.side = index(d);
                lent.turn = lent.loads.least(lent.across);
                lent.guest_splats = splats.size();
                auto const r = rect_of_guest(here, *frame, lent);
                guest.resize((r.x1 - r.x0) * (r.y1 - r.y0));
            }
            for (auto const& message : in[d]) splats.unchecked_push(message.entry);
        }
        // Accept offers. They are there in the first pass.
        auto const grid = detail::blocks_of(*frame, here.tile);
        detail::Offers offers{};
        bool any = false;
        for (Direction d : news)
            if (!loads[d].empty()) offers.of[index(d)] = loads[d][0], any = true;
        if (any) {
            detail::choose_strips(BlockLoads(grid, counts), offers, lent);
            looked.slots += 4 * 3 * grid.strips * grid.across; // at most: three loads for each side
        }
        // Send.
        bool more = false;
        auto const at = AccessOf<S>::in_order(*frame, splats.begin(), order.begin());
        for (Direction d : news) {
            std::uint32_t const strip = lent.strip[index(d)], n = order.size();
            std::uint32_t& next = lent.next[index(d)];
            if (strip == 0 || next == n) continue;
            looked.slots -= next;
            for (; next < n; ++next) {
                auto const touched = grid.strips_of(at(next));
                if (strip <= touched.first || strip > touched.last) continue;
                if (out[d].room() == 0) break;
                out[d].unchecked_push({splats[order[next].slot]});
            }
            out[d].set_note(strip);
            looked.slots += next;
            more = more || next < n;
        }
        return more ? Vote::busy : Vote::quiet;
    }
    static PixelRect rect_of_guest(Here const& here, typename S::Parameters const& frame, LentStrips const& lent) noexcept
    {
        return detail::blocks_of(frame, here.grid.neighbour(here.tile, news[lent.side])).rect(lent.guest - 1, lent.guest);
    }
    /// For a cost model. A splat that comes or goes costs as much as a record on its way.
    static Operations operations(LookedAt const& looked, In<LentSplats<S>> in, Out<LentSplats<S>> out) noexcept
    {
        Operations o;
        for (Direction d : news) o[Operation::routed] += in[d].size() + out[d].size();
        o[Operation::slot] = looked.slots;
        return o;
    }
};

template <class S>
struct CompositeLending {
    static constexpr char const* name = "composite and lend";
    static constexpr std::uint32_t most_workers = Work::max_workers;

    void operator()(Here here, Broadcast<typename S::Parameters> frame, Splats<S> const& splats, Order<S> const& order,
                    LentStrips const& lent, Framebuffer<S>& framebuffer, GuestPixels<S>& guest, Work& work, Worker worker) const noexcept
    {
        Parts const parts(here, *frame, lent);
        auto const& own = parts.own;
        auto const at = AccessOf<S>::in_order(*frame, splats.begin(), order.begin());
        auto pairs = S::Blending::tile(own, *frame, order.size(), at, framebuffer.begin() + parts.skipped, own.x1 - own.x0, worker);
        if (lent.guest != 0) {
            GuestSplats const theirs{*frame, splats.begin() + lent.guest_splats};
            Worker const turned{(worker.index + worker.count - lent.turn % worker.count) % worker.count, worker.count};
            auto const more = S::Blending::tile(parts.theirs, *frame, splats.size() - lent.guest_splats, theirs, guest.begin(),
                                                parts.theirs.x1 - parts.theirs.x0, turned);
            pairs.evaluated += more.evaluated;
            pairs.contributing += more.contributing;
        }
        work.evaluated[worker.index] = pairs.evaluated;
        work.contributing[worker.index] = pairs.contributing;
    }

    /// For a cost model. All workers wait for the worker with the most pairs.
    static Operations operations(LentStrips const& lent, Framebuffer<S> const& framebuffer, GuestPixels<S> const& guest, Work const& work,
                                 Worker worker) noexcept
    {
        std::uint32_t most = 0;
        for (std::uint32_t w = 0; w < worker.count; ++w) most = work.evaluated[w] > most ? work.evaluated[w] : most;
        Operations o;
        o[Operation::pair] = times(most, worker.count * pairs_a_count);
        o[Operation::pixel] = framebuffer.size() + (lent.guest != 0 ? guest.size() : 0);
        return o;
    }

    /// Computes the shares of all workers at once, for a host thread.
    struct AllWorkers {
        static constexpr char const* name = CompositeLending::name;
        void operator()(Here here, Broadcast<typename S::Parameters> frame, Splats<S> const& splats, Order<S> const& order,
                        LentStrips const& lent, Framebuffer<S>& framebuffer, GuestPixels<S>& guest, Work& work,
                        Worker worker) const noexcept
        {
            Parts const parts(here, *frame, lent);
            auto const& own = parts.own;
            auto const at = AccessOf<S>::in_order(*frame, splats.begin(), order.begin());
            PairCount pairs[Work::max_workers] = {}, more[Work::max_workers] = {};
            S::Blending::whole(own, *frame, order.size(), at, framebuffer.begin() + parts.skipped, own.x1 - own.x0, pairs, worker.count);
            if (lent.guest != 0) {
                GuestSplats const theirs{*frame, splats.begin() + lent.guest_splats};
                S::Blending::whole(parts.theirs, *frame, splats.size() - lent.guest_splats, theirs, guest.begin(),
                                   parts.theirs.x1 - parts.theirs.x0, more, worker.count);
            }
            for (std::uint32_t w = 0; w < worker.count; ++w) {
                auto const& turned = more[(w + worker.count - lent.turn % worker.count) % worker.count];
                work.evaluated[w] = pairs[w].evaluated + turned.evaluated;
                work.contributing[w] = pairs[w].contributing + turned.contributing;
            }
        }
    };

private:
    /// The splats of a lent strip, front to back.
    struct GuestSplats {
        typename S::Parameters const& frame;
        typename S::Projected const* entries;
        TILEMESH_KERNEL Splat const& operator()(std::uint32_t i) const noexcept { return AccessOf<S>::splat_of(frame, entries[i]); }
    };
    /// What a tile blends.
    struct Parts {
        PixelRect own, theirs{0, 0, 0, 0};
        std::uint32_t skipped; ///< pixels of the tile before its own
        Parts(Here const& here, typename S::Parameters const& frame, LentStrips const& lent) noexcept
        {
            auto const grid = detail::blocks_of(frame, here.tile);
            own = lent.first == 0 && lent.last == grid.strips ? grid.tile : grid.rect(lent.first, lent.last);
            skipped = (own.y0 - grid.tile.y0) * (own.x1 - own.x0);
            if (lent.guest != 0) theirs = LendStrips<S>::rect_of_guest(here, frame, lent);
        }
    };
};

template <class S>
struct ReturnPixels {
    static constexpr char const* name = "return pixels";
    Vote operator()(Here here, Broadcast<typename S::Parameters> frame, Splats<S>& splats, LentStrips& lent, Framebuffer<S>& framebuffer,
                    GuestPixels<S>& guest, In<LentPixels<S>> in, Out<LentPixels<S>> out) const noexcept
    {
        auto const grid = detail::blocks_of(*frame, here.tile);
        for (Direction d : news) {
            std::uint32_t const strip = lent.strip[index(d)], n = in[d].size();
            if (strip == 0 || n == 0) continue;
            auto const r = grid.rect(strip - 1, strip);
            auto* const to = framebuffer.begin() + (r.y0 - grid.tile.y0) * (r.x1 - r.x0);
            for (std::uint32_t i = 0; i < n; ++i) to[lent.back[index(d)] + i] = in[d][i];
            lent.back[index(d)] += n;
        }
        if (lent.guest == 0) return Vote::quiet;
        auto& end = out[news[lent.side]];
        for (; lent.sent < guest.size() && end.room() != 0; ++lent.sent) end.unchecked_push(guest[lent.sent]);
        if (lent.sent < guest.size()) return Vote::busy;
        splats.truncate(lent.guest_splats);
        guest.truncate(0);
        lent.guest = 0;
        return Vote::quiet;
    }
    /// For a cost model.
    static Operations operations(In<LentPixels<S>> in, Out<LentPixels<S>> out) noexcept
    {
        Operations o;
        for (Direction d : news) o[Operation::pixel] += in[d].size() + out[d].size();
        return o;
    }
};
} // namespace kernel

/// The steps of a frame after the depth sort, if its setup lends strips.
template <class S>
struct LendingSteps {
    using P = PoliciesOf<S>;
    using Composite = kernel::CompositeLending<P>;
    using type = Sequence<Superstep<kernel::TellLoad<P>>, Superstep<kernel::OfferHelp<P>>, UntilQuiet<kernel::LendStrips<P>>,
                          Superstep<Composite>, Superstep<kernel::ReturnPixels<P>>, UntilQuiet<kernel::ReturnPixels<P>>>;
};

}}} // namespace tilemesh::splat
