#pragma once
#include <cstdint>
#include <tilemesh/splat/blending_hits.hpp>
#include <tilemesh/splat/homes/regions.hpp>
#include <tilemesh/splat/depth_sort.hpp>
#include <type_traits>

/// Brings splats from their homes to the tiles whose windows want them.
///
/// A home knows all windows (tell.hpp). It names the tiles that want a splat in the parcel itself, so tiles on the way look nothing up. A
/// parcel goes along the row of its home to the columns that it names, and from there up and down. Where it splits, each part has its own
/// tiles (multicast with the destinations in the header).
///
/// The protocol. Let c be the slots of a channel end, and q the slots of a FIFO.
///   1. Parcels on a column go first; they never wait. At most c arrive on a side. Each either ends or goes straight on to the opposite
///      side, whose channel is empty when compute begins.
///   2. Parcels on a row may find a column's channel full, or no credit ahead. They wait in the FIFO of their side, and keep only the tiles
///      that are still owed. The FIFO is served before new arrivals: first the parcels that turn here, then those that go straight on.
///   3. A tile tells each row neighbour the fill of the FIFO on that side, as the note of the channel back. It sends to a row neighbour at
///      most q - (the fill it was told) - (its number of parcels sent in the pass before), and at most c.
///   4. A home's own parcels leave last. Its three ways (west, east, own column) do not wait for each other.
///
/// The window that a parcel ends in always accepts it: if the tile has no room, it keeps the nearer of two splats and moves its frontier.
/// So parcels on columns always drain, and a row waits only for columns, or for the next FIFO in the same direction. Directions end at the
/// edge: there is no cycle, and delivery ends for any c, q >= 1 (routing.hpp has the argument for the credits).
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::homes {

namespace detail {
using namespace splat::detail;

/// The tiles of byte c of `to` that lie north of row r, at it, and south of it, as bits of a byte; r may be any number.
struct ColumnSplit {
    std::uint32_t north, here, south;
};
TILEMESH_KERNEL ColumnSplit split_column(std::uint32_t to, std::uint32_t c, std::int32_t r) noexcept
{
    std::uint32_t const byte = to >> (8 * c) & 0xffu;
    if (r < 0) return {0, 0, byte};
    if (r >= 8) return {byte, 0, 0};
    std::uint32_t const here = 1u << r;
    return {byte & (here - 1), byte & here, byte & ~(here | (here - 1))};
}
/// The bytes of `to` before byte c, and after it; c may be any number.
TILEMESH_KERNEL std::uint32_t columns_before(std::uint32_t to, std::int32_t c) noexcept
{
    return c <= 0 ? 0u : c >= 4 ? to : to & ((1u << (8 * c)) - 1);
}
TILEMESH_KERNEL std::uint32_t columns_after(std::uint32_t to, std::int32_t c) noexcept
{
    return c < 0 ? to : to & ~columns_before(0xffffffffu, c + 1);
}
TILEMESH_KERNEL std::uint32_t bits_in(std::uint32_t v) noexcept
{
    v = v - (v >> 1 & 0x55555555u); // in plain words: GCC's builtin calls its own library
    v = (v & 0x33333333u) + (v >> 2 & 0x33333333u);
    return ((v + (v >> 4)) & 0x0f0f0f0fu) * 0x01010101u >> 24;
}

/// The first pixels of the blocks of a rectangle of at most `most` blocks, row by row, relative to the first block's: for each width.
struct BlockSteps {
    static constexpr std::uint32_t widest = 8, most = 32;
    alignas(64) std::int32_t column[widest + 1][most], row[widest + 1][most];
    constexpr BlockSteps() noexcept : column{}, row{}
    {
        for (std::uint32_t w = 1; w <= widest; ++w)
            for (std::uint32_t k = 0; k < most; ++k) {
                column[w][k] = static_cast<std::int32_t>(k % w * block_width);
                row[w][k] = static_cast<std::int32_t>(k / w * block_height);
            }
    }
};
inline constexpr BlockSteps block_steps{};

/// The tiles that want one splat: it is in the tile's window, and a pixel of an unfinished block may see it. The block's test is that of
/// blending.
template <class AnyFold, class Windows>
class Wanted {
public:
    Wanted(Splat const& s, AnyFold const& fold, Camera const& camera, Windows const& windows) noexcept
        : fold_(fold), camera_(camera), windows_(windows), splat_(s), depth_(s.depth_key)
    {
        auto const r = s.rect();
        i0_ = r.x0 / block_width;
        i1_ = (r.x1 - 1) / block_width;
        j0_ = r.y0 / block_height;
        j1_ = (r.y1 - 1) / block_height;
        x_ = fold.x.tiles_of(i0_, i1_);
        y_ = fold.y.tiles_of(j0_, j1_);
        float const steep = s.across * s.slope; // as Chunk::complete
        steepest_ = steep / (s.along + steep * s.slope);
    }
    std::uint32_t parts() const noexcept { return parts_x() * ((y_.last - y_.first) / parcel_rows + 1); }
    /// The first tile of a part.
    TileId first(std::uint32_t part) const noexcept
    {
        return TileId::at(x_.first + part % parts_x() * parcel_columns, y_.first + part / parts_x() * parcel_rows);
    }
    /// The tiles of a part in columns x0 to x1 - 1 that want the splat, as in Parcel::to. It asks tile by tile.
    std::uint32_t tiles(std::uint32_t part, std::uint32_t x0, std::uint32_t x1) const noexcept
    {
        TileId const from = first(part);
        std::uint32_t to = 0;
        for (std::uint32_t c = 0; c < parcel_columns; ++c) {
            std::uint32_t const x = from.x() + c;
            if (x < x0 || x >= x1 || x > x_.last) continue;
            for (std::uint32_t r = 0; r < parcel_rows && from.y() + r <= y_.last; ++r)
                if (wants(x, from.y() + r)) to |= 1u << (8 * c + r);
        }
        return to;
    }
    /// All tiles that want the splat, if there is one part. It asks block by block, N blocks at once.
    template <std::uint32_t N = native_lanes>
    std::uint32_t all_tiles(std::uint32_t& tested) const noexcept
    {
        Blocks<N> blocks;
        std::uint32_t to = 0;
        auto const test = [&]() noexcept {
            tested += blocks.n;
            to |= seen_of(blocks);
            blocks.n = 0;
        };
        each_block<true>([&](std::uint32_t i, std::uint32_t j, std::uint32_t, std::uint32_t bit) noexcept {
            blocks.column[blocks.n] = static_cast<std::int32_t>(i * block_width);
            blocks.row[blocks.n] = static_cast<std::int32_t>(j * block_height);
            blocks.bits[blocks.n] = 1u << bit;
            if (++blocks.n == N) test();
        });
        if (blocks.n != 0) test();
        return to;
    }
    /// The same for a host. It tests all blocks of the splat's rectangle before it asks which of them are wanted.
    template <std::uint32_t N = native_lanes>
    std::uint32_t all_tiles_at_once(std::uint32_t& tested) const noexcept
    {
        std::uint32_t const width = i1_ - i0_ + 1, n = width * (j1_ - j0_ + 1);
        if (width > BlockSteps::widest || n > BlockSteps::most) return all_tiles<N>(tested);
        alignas(vector_bytes) std::int32_t seen[BlockSteps::most];
        auto const column = static_cast<std::int32_t>(i0_ * block_width), row = static_cast<std::int32_t>(j0_ * block_height);
        for (std::uint32_t k = 0; k < n; k += N)
            store(seen + k, reach<N>(load_words<N>(block_steps.column[width] + k) + column, load_words<N>(block_steps.row[width] + k) + row));
        std::uint32_t k = 0, to = 0;
        each_block<false>([&](std::uint32_t, std::uint32_t, std::uint32_t wanted, std::uint32_t bit) noexcept { // no branch
            tested += wanted;
            to |= (static_cast<std::uint32_t>(seen[k++]) & wanted) << bit;
        });
        return to;
    }

private:
    template <std::uint32_t N>
    struct Blocks {
        std::int32_t column[N], row[N];
        std::uint32_t bits[N];
        std::uint32_t n;
        Blocks() noexcept : n(0) {} // the others have no value yet
    };
    /// The bits of the blocks that may see the splat.
    template <std::uint32_t N>
    std::uint32_t seen_of(Blocks<N>& blocks) const noexcept
    {
        for (std::uint32_t k = blocks.n; k < N; ++k) blocks.column[k] = blocks.column[0], blocks.row[k] = blocks.row[0];
        alignas(vector_bytes) std::int32_t seen[N];
        store(seen, reach<N>(load_words<N>(blocks.column), load_words<N>(blocks.row)));
        std::uint32_t to = 0;
        for (std::uint32_t k = 0; k < blocks.n; ++k) to |= seen[k] != 0 ? blocks.bits[k] : 0u;
        return to;
    }
    std::uint32_t parts_x() const noexcept { return (x_.last - x_.first) / parcel_columns + 1; }
    /// Calls f(i, j, wanted, bit) with each block of the splat's rectangle, row by row. `wanted`: 1 if the splat is in the window of the
    /// block's tile and the block is not finished, otherwise 0. `bit`: the tile's in Parcel::to, if there is one part. `OnlyWanted` leaves out
    /// the other blocks, by branches: less code.
    template <bool OnlyWanted, class F>
    TILEMESH_KERNEL void each_block(F const& f) const noexcept
    {
        auto const bit_of = [](bool yes) noexcept { return yes ? 1u : 0u; };
        auto const first_x = fold_.x.cursor(i0_);
        auto y = fold_.y.cursor(j0_);
        for (std::uint32_t j = j0_; j <= j1_; ++j, y = fold_.y.next(y)) {
            std::uint32_t const ty = fold_.y.tile(y);
            auto const notices = windows_of_row(windows_, fold_, ty);
            auto x = first_x;
            for (std::uint32_t i = i0_; i <= i1_; ++i, x = fold_.x.next(x)) {
                std::uint32_t const tx = fold_.x.tile(x);
                WindowNotice const& t = notices[tx];
                if constexpr (OnlyWanted)
                    if (depth_ < t.lo_depth || depth_ >= t.hi_depth) continue;
                std::uint32_t const finished = t.finished & fold_.bit_of(fold_.y.number(y) * fold_.x.layers + fold_.x.number(x));
                if constexpr (OnlyWanted) {
                    if (finished == 0) f(i, j, 1, 8 * (tx - x_.first) + (ty - y_.first));
                    continue;
                }
                f(i, j, bit_of(depth_ >= t.lo_depth) & bit_of(depth_ < t.hi_depth) & bit_of(finished == 0), 8 * (tx - x_.first) + (ty - y_.first));
            }
        }
    }
    bool wants(std::uint32_t x, std::uint32_t y) const noexcept
    {
        WindowNotice const& notice = windows_of_row(windows_, fold_, y)[x];
        if (depth_ < notice.lo_depth || depth_ >= notice.hi_depth) return false;
        for (std::uint32_t k = 0; k < fold_.x.layers; ++k) {
            std::uint32_t const i = fold_.x.block(x, k);
            if (i - i0_ > i1_ - i0_) continue; // also a block that does not exist
            for (std::uint32_t l = 0; l < fold_.y.layers; ++l) {
                std::uint32_t const j = fold_.y.block(y, l);
                if (j - j0_ > j1_ - j0_ || (notice.finished & fold_.bit_of(l * fold_.x.layers + k)) != 0) continue;
                std::int32_t const column = static_cast<std::int32_t>(i * block_width), row = static_cast<std::int32_t>(j * block_height);
                if (reach<1>(broadcast_word<1>(column), broadcast_word<1>(row))[0] != 0) return true;
            }
        }
        return false;
    }
    /// May a pixel of these blocks see the splat? `x`, `y`: first pixels.
    template <std::uint32_t N>
    TILEMESH_KERNEL Words<N> reach(Words<N> const& x, Words<N> const& y) const noexcept
    {
        Form<N> const form{broadcast<N>(splat_.along), broadcast<N>(splat_.slope), broadcast<N>(splat_.across), broadcast<N>(steepest_),
                           broadcast<N>(splat_.faintest)};
        auto const centre = [](Words<N> const& pixel, float origin, float mean) noexcept {
            return __builtin_convertvector(pixel, Floats<N>) + 0.5f - origin - mean;
        };
        return reaches<N>(form, centre(x, camera_.cx, splat_.mean_px[0]),
                          centre(x + static_cast<std::int32_t>(block_width - 1), camera_.cx, splat_.mean_px[0]),
                          centre(y, camera_.cy, splat_.mean_px[1]),
                          centre(y + static_cast<std::int32_t>(block_height - 1), camera_.cy, splat_.mean_px[1]));
    }

    AnyFold const& fold_;
    Camera const& camera_;
    Windows const& windows_;
    Splat const& splat_;
    std::uint32_t depth_, i0_, i1_, j0_, j1_; ///< blocks of the splat's rectangle, inclusive
    float steepest_;
    Axis::Range x_, y_;                       ///< tiles that own them
};

/// Notes a key that the tile does not take in this round: it is behind the frontier.
TILEMESH_KERNEL void refuse(Key key, Window& window, Sample& sample, Counts& counts) noexcept
{
    ++counts.refused;
    // A sample of the refused depths: when it is full, every second one goes.
    if (window.seen++ % window.stride != 0) return;
    if (sample.size() == sample.capacity()) {
        for (std::uint32_t i = 0; i < most_samples / 2; ++i) sample[i] = sample[2 * i];
        sample.truncate(most_samples / 2);
        window.stride *= 2;
    }
    sample.push(key.depth);
}

/// Moves the frontier of a full tile nearer, so that about 1 splat of 20, and at least the farthest of these and of the one that arrives, are
/// behind it; they leave. At least the nearest stays. A pivot from a sample takes one look at each key, where a heap takes log2 n
/// comparisons for each splat that leaves.
template <class P>
void make_room(Key arrives, Window& window, Held<P>& held, Keys& keys, Sample& sample, Counts& counts) noexcept
{
    constexpr std::uint32_t most_picks = 64;
    std::uint32_t n = held.size();
    std::uint32_t const picks = n < most_picks ? n : most_picks, behind = 1 + picks / 32;
    SortKey const arrived{arrives.depth, GaussianId{arrives.id}, 0};
    SortKey pivot{infinite_depth, GaussianId{0}, 0}; // becomes the farthest of the picks, then the next one
    for (std::uint32_t k = 0; k < behind; ++k) {
        SortKey farthest = arrived < pivot ? arrived : SortKey{};
        for (std::uint32_t i = 0; i < picks; ++i) {
            SortKey const& key = keys[n / picks * i + n % picks * i / picks];
            if (farthest < key && key < pivot) farthest = key;
        }
        pivot = farthest;
    }
    window.frontier_depth = pivot.depth_key;
    window.frontier_id = static_cast<std::uint32_t>(pivot.id);
    counts.scanned += n + behind * picks;
    for (std::uint32_t i = 0; i < n;) {
        if (keys[i] < pivot) {
            ++i;
            continue;
        }
        refuse({keys[i].depth_key, static_cast<std::uint32_t>(keys[i].id)}, window, sample, counts);
        keys[i] = keys[--n];
        keys[i].slot = i;
        held[i] = held[n];
        ++counts.compared;
    }
    held.truncate(n);
    keys.truncate(n);
}

/// Puts a splat that has arrived among those that the tile holds, or refuses it. A full tile makes room: the nearest stay, and the frontier
/// is the nearest key that does not.
template <class P>
TILEMESH_KERNEL void hold(Key key, typename P::Projected const& splat, Window& window, Held<P>& held, Keys& keys, Sample& sample,
                          Counts& counts) noexcept
{
    if (key < Key{window.lo_depth, window.lo_id}) {
        ++counts.early;
        ++counts.turned_away;
        return;
    }
    if constexpr (P::Parameters::has_districts)
        if (key.depth >= window.hi_depth) { // another tile of the district wants it
            ++counts.early;
            ++counts.turned_away;
            return;
        }
    auto const behind = [&]() noexcept { return !(key < Key{window.frontier_depth, window.frontier_id}); };
    if (held.size() == held.capacity() && !behind()) make_room<P>(key, window, held, keys, sample, counts);
    if (behind()) {
        refuse(key, window, sample, counts);
        ++counts.turned_away;
        return;
    }
    keys.unchecked_push({key.depth, GaussianId{key.id}, held.size()});
    held.unchecked_push(splat);
}
} // namespace detail

/// Finds, for each record of a home, the tiles that want its splat in this round. All workers share the records. No exchange.
template <class P>
struct Offer {
    static constexpr char const* name = "offer";
    using FrameParameters = typename P::Parameters;
    using Access = splat::Access<FrameParameters>;

    void operator()(Broadcast<FrameParameters> parameters, Seen<P> const& seen, Table const& table, Offers& offers, Worker worker) const noexcept
    {
        with_windows(*parameters, table, [&](auto const& windows) noexcept { find(*parameters, parameters->fold, seen, windows, offers, worker); });
    }
    /// Does the shares of all workers at once, for a host thread.
    struct AllWorkers {
        static constexpr char const* name = Offer::name;
        void operator()(Broadcast<FrameParameters> parameters, Seen<P> const& seen, Table const& table, Offers& offers, Worker) const noexcept
        {
            with_windows(*parameters, table, [&](auto const& windows) noexcept {
                if (seen.size() >= fewest_by_table && FoldTable::has_room(parameters->fold))
                    find(*parameters, FoldTable(parameters->fold), seen, windows, offers, {0, 1});
                else
                    find(*parameters, parameters->fold, seen, windows, offers, {0, 1});
            });
        }
    };
    /// For a cost model. All workers wait for the one with the most blocks. A test of a block takes about 60 instructions, as two comparisons
    /// (KernelWork). Records that nobody wants are not counted.
    static Operations operations(Offers const& offers, Worker worker) noexcept
    {
        std::uint32_t tested = 0;
        for (Offered const& o : offers) tested += o.tested;
        Operations out;
        out[Operation::slot] = (offers.size() + worker.count - 1) / worker.count;
        out[Operation::comparison] = times(2, (tested + worker.count - 1) / worker.count);
        return out;
    }

private:
    static constexpr std::uint32_t fewest_by_table = 32; ///< records; for fewer, the tables of a fold cost more than its divisions

    template <class AnyFold, class Windows>
    TILEMESH_KERNEL static void find(FrameParameters const& frame, AnyFold const& fold, Seen<P> const& seen, Windows const& windows,
                                     Offers& offers, Worker worker) noexcept
    {
        for (std::uint32_t i = worker.index, n = seen.size(); i < n; i += worker.count) {
            Splat const& s = Access::splat_of(frame, seen[i]);
            offers[i] = {};
            if (!s.visible()) continue;
            detail::Wanted const wanted(s, fold, frame.view.camera, windows);
            std::uint32_t const parts = wanted.parts();
            std::uint32_t tested = 0, to = 0;
            if (parts == 1) {
                if constexpr (std::is_same_v<AnyFold, FoldTable>) // only a host has it
                    to = wanted.all_tiles_at_once(tested);
                else
                    to = wanted.all_tiles(tested);
            }
            if (parts == 1 && to == 0) continue;
            offers[i] = {wanted.first(0), to, half(parts), half(tested)};
        }
    }
    /// n in 16 bits: a larger number becomes the largest. Above 1 only whether there are several parts is asked, and how many is counted anew.
    TILEMESH_KERNEL static std::uint16_t half(std::uint32_t n) noexcept { return static_cast<std::uint16_t>(n < 0xffffu ? n : 0xffffu); }
};

template <class P>
struct Deliver {
    static constexpr char const* name = "deliver";
    using FrameParameters = typename P::Parameters;
    using Message = Parcel<typename P::Projected>;
    using Access = splat::Access<FrameParameters>;

    Vote operator()(Here here, Broadcast<FrameParameters> frame, Home<P> const& home, Seen<P> const& seen, Offers const& offers,
                    Table const& table, Window& window, Held<P>& held, Keys& keys, Sample& sample, Waiting<P, 0>& waiting0,
                    Waiting<P, 1>& waiting1, Sending& sending, Counts& counts, In<Parcels<P>> in, Out<Parcels<P>> out) const noexcept
    {
        bool const mail = !in[Direction::north].empty() || !in[Direction::south].empty() || !in[Direction::west].empty() ||
                          !in[Direction::east].empty();
        bool const own = sending.record[0] < offers.size() || sending.record[1] < offers.size() || sending.record[own_column] < offers.size();
        if (!mail && !own && waiting0.empty() && waiting1.empty() && sending.sent[0] == 0 && sending.sent[1] == 0) return Vote::quiet;

        if constexpr (Access::on_host) {
            __builtin_prefetch(keys.begin() + keys.size(), 1);
            __builtin_prefetch(held.begin() + held.size(), 1);
        }
        counts.compared = counts.scanned = counts.turned_away = 0;
        std::uint32_t const arrived = counts.arrived;
        Tile tile{here, *frame, window, held, keys, sample, counts, {}, {}};
        for (Direction d : news) tile.way[index(d)] = {out[d].begin(), 0, out[d].capacity(), false};
        for (std::uint32_t leg = 0; leg < 2; ++leg) { // on a row also the credit of the FIFO behind the channel
            Way& way = tile.way[index(row[leg])];
            std::uint32_t const used = in[row[leg]].note() + sending.sent[leg];
            std::uint32_t const behind = leg == 0 ? waiting1.capacity() : waiting0.capacity();
            std::uint32_t const credit = used < behind ? behind - used : 0;
            if (credit < way.limit) {
                way.limit = credit;
                way.short_of_credit = true;
            }
        }
        for (Direction from : {Direction::north, Direction::south})
            if constexpr (Access::on_host)
                tile.pass_column(in[from], opposite(from));
            else
                for (Message const& m : in[from])
                    (void)TILEMESH_EXPECT(tile.serve_column(m, here.tile.x() - m.first().x(), m.to) == 0,
                                      "a parcel on a column found no room (its channel was not empty); report this");
        tile.empty_fifo(waiting0, sending.turning[0], in[Direction::west], Direction::east);
        tile.empty_fifo(waiting1, sending.turning[1], in[Direction::east], Direction::west);
        std::uint32_t const passed = tile.given();
        bool open = false; // its own records: to the west, to the east, and on its own column
        for (std::uint32_t way = 0; own && way < 3; ++way) open = with_windows(*frame, table, [&](auto const& windows) noexcept {
            return send_own(tile, way, *frame, home, seen, offers, windows, sending);
        }) || open;
        tile.take_all();

        for (Direction d : news) out[d].resize(tile.way[index(d)].n);
        counts.hops += tile.given();
        counts.passed = passed;
        counts.left = tile.given() - passed;
        counts.settled = counts.arrived - arrived;
        out[Direction::west].set_note(waiting0.size());
        out[Direction::east].set_note(waiting1.size());
        sending.sent[0] = out[Direction::west].size();
        sending.sent[1] = out[Direction::east].size();
        bool const quiet = !open && waiting0.empty() && waiting1.empty() && sending.sent[0] == 0 && sending.sent[1] == 0;
        return quiet ? Vote::quiet : Vote::busy;
    }

    /// For a cost model. A parcel that waits in a FIFO is looked at in each pass. A splat that arrives and is refused is as much work
    /// as a comparison, and so is one that leaves a full tile: another one is moved into its place.
    static Operations operations(Counts const& counts, Waiting<P, 0> const& waiting0, Waiting<P, 1> const& waiting1) noexcept
    {
        Operations o;
        o[Operation::slot] = waiting0.size() + waiting1.size() + counts.scanned;
        o[Operation::left] = counts.left;
        o[Operation::passed] = counts.passed;
        o[Operation::settled] = counts.settled - counts.turned_away;
        o[Operation::comparison] = counts.compared + counts.turned_away;
        o.settled_bytes = times(counts.settled, wire_bytes<Message>);
        return o;
    }

private:
    static constexpr Direction row[2] = {Direction::west, Direction::east};
    static constexpr std::uint32_t own_column = 2;
    /// All bits if 0 <= a < b, otherwise none, for a difference of coordinates a. Of a comparison, GCC 12 would make a branch, which a
    /// predictor cannot know.
    TILEMESH_KERNEL static std::uint32_t all_if_below(std::uint32_t a, std::uint32_t b) noexcept
    {
        return static_cast<std::uint32_t>(static_cast<std::int32_t>((a - b) & ~a) >> 31);
    }

    /// A way out of the tile: what it sends there, and how much it may.
    struct Way {
        Message* parcels;
        std::uint32_t n, limit;
        bool short_of_credit;
    };
    /// What has arrived, on a host.
    struct ArrivalsOnHost {
        static constexpr std::uint32_t most = 128;
        std::uint32_t n;
        typename P::Projected splats[most];
        ArrivalsOnHost() noexcept : n(0) {} // the others have no value yet
    };
    struct NoArrivals {};
    using Arrivals = std::conditional_t<Access::on_host, ArrivalsOnHost, NoArrivals>;
    /// What the tile does with parcels in one pass.
    struct Tile {
        Here const& here;
        FrameParameters const& frame;
        Window& window;
        Held<P>& held;
        Keys& keys;
        Sample& sample;
        Counts& counts;
        Way way[4];
        Arrivals arrivals;

        /// Takes a parcel that ends here. A host takes it later, when its key has come from memory.
        TILEMESH_KERNEL void take(Message const& m) noexcept
        {
            ++counts.arrived;
            if constexpr (Access::on_host) {
                if (arrivals.n == Arrivals::most) take_all();
                Access::about_to_take(frame, m.projected());
                arrivals.splats[arrivals.n++] = m.projected();
            } else {
                detail::hold<P>(m.key(), m.projected(), window, held, keys, sample, counts);
            }
        }
        void take_all() noexcept
        {
            if constexpr (Access::on_host) {
                for (std::uint32_t i = 0; i < arrivals.n; ++i)
                    detail::hold<P>(Access::key_of(frame, arrivals.splats[i]), arrivals.splats[i], window, held, keys, sample, counts);
                arrivals.n = 0;
            }
        }
        std::uint32_t given() const noexcept { return way[0].n + way[1].n + way[2].n + way[3].n; }
        TILEMESH_KERNEL bool room(Direction d) noexcept
        {
            Way const& w = way[index(d)];
            if (w.n < w.limit) return true;
            ++counts.refusals(w.short_of_credit);
            return false;
        }
        TILEMESH_KERNEL void send(Message const& m, Direction d, std::uint32_t to) noexcept
        {
            Way& w = way[index(d)];
            w.parcels[w.n] = m;
            w.parcels[w.n++].to = to;
        }
        /// Serves this column's tiles of `to`: this one, those north and those south. Returns the tiles that a full channel leaves.
        std::uint32_t serve_column(Message const& m, std::uint32_t c, std::uint32_t to) noexcept
        {
            auto split = detail::split_column(to, c, static_cast<std::int32_t>(here.tile.y()) - static_cast<std::int32_t>(m.first().y()));
            if (split.here != 0) take(m);
            if (split.north != 0 && room(Direction::north)) send(m, Direction::north, split.north << (8 * c)), split.north = 0;
            if (split.south != 0 && room(Direction::south)) send(m, Direction::south, split.south << (8 * c)), split.south = 0;
            return (split.north | split.south) << (8 * c);
        }
        /// `serve_column` for all arrivals of a column, for a host. They end here or go on towards d, whose channel is empty. The tiles that they
        /// name are all in this column.
        template <class Arrived>
        TILEMESH_KERNEL void pass_column(Arrived const& all, Direction d) noexcept
        {
            Way& w = way[index(d)];
            Message* next = w.parcels;
            std::uint32_t const y = here.tile.y();
            constexpr std::uint32_t part = 64;
            Message const* own[part];
            for (Message const *m = all.begin(), *const end = all.end(); m != end;) {
                std::uint32_t owns = 0; // no branch: a predictor cannot know the tiles
                for (Message const* const stop = end - m < part ? end : m + part; m != stop; ++m) {
                    std::uint32_t const r = y - m->first().y(); // wraps north of its rows
                    std::uint32_t const mine = m->to & 0x01010101u << r % parcel_rows & all_if_below(r, parcel_rows), rest = m->to ^ mine;
                    own[owns] = m;
                    owns += mine != 0 ? 1u : 0u;
                    *next = *m;
                    next->to = rest;
                    next += rest != 0 ? 1 : 0;
                }
                for (std::uint32_t i = 0; i < owns; ++i) take(*own[i]);
            }
            w.n = static_cast<std::uint32_t>(next - w.parcels);
        }
        /// Do all tiles of this column's `to` lie behind full channels? If so, the parcel waits, and the refusals are counted.
        TILEMESH_KERNEL bool column_is_full(TileId parcel_first, std::uint32_t c, std::uint32_t to) noexcept
        {
            auto const split = detail::split_column(to, c, static_cast<std::int32_t>(here.tile.y()) - static_cast<std::int32_t>(parcel_first.y()));
            auto const full = [&](Direction d) noexcept { return way[index(d)].n >= way[index(d)].limit; };
            if (split.here != 0 || (split.north != 0 && !full(Direction::north)) || (split.south != 0 && !full(Direction::south))) return false;
            if (split.north != 0) (void)room(Direction::north);
            if (split.south != 0) (void)room(Direction::south);
            return true;
        }
        /// Serves a parcel that goes along the row towards d. Returns the tiles that are still owed.
        TILEMESH_KERNEL std::uint32_t serve_row(Message const& m, Direction d) noexcept
        {
            auto const c = static_cast<std::int32_t>(here.tile.x()) - static_cast<std::int32_t>(m.first().x());
            std::uint32_t ahead = d == Direction::east ? detail::columns_after(m.to, c) : detail::columns_before(m.to, c);
            std::uint32_t rest = 0;
            if (ahead != m.to) rest = serve_column(m, static_cast<std::uint32_t>(c), m.to);
            if (ahead != 0 && room(d)) send(m, d, ahead), ahead = 0;
            return rest | ahead;
        }
        /// Serves the parcels that wait, then those that have arrived. Those that go straight on are looked at only while there is room ahead.
        template <class Fifo, class Arrived>
        void empty_fifo(Fifo& waiting, std::uint32_t& turning, Arrived const& arrived, Direction d) noexcept
        {
            std::uint32_t kept = 0, next = turning;
            std::uint32_t const n = waiting.size();
            for (std::uint32_t i = 0; i < turning; ++i) {
                std::uint32_t const owed = serve_row(waiting[i], d);
                if (owed == 0) continue;
                if (kept != i) waiting[kept] = waiting[i];
                waiting[kept++].to = owed;
            }
            Way& ahead = way[index(d)];
            for (; next < n && ahead.n < ahead.limit; ++next) send(waiting[next], d, waiting[next].to);
            counts.refusals(ahead.short_of_credit) += n - next;
            if (next != kept) __builtin_memmove(waiting.begin() + kept, waiting.begin() + next, (n - next) * sizeof(Message));
            waiting.truncate(kept + (n - next));
            turning = kept;
            auto const keep = [&](Message const& m, std::uint32_t owed) noexcept {
                Message rest = m;
                rest.to = owed;
                if (!TILEMESH_EXPECT(waiting.try_push(rest), "a FIFO was sent more than its credit (flow control is broken); report this")) return;
                auto const c = static_cast<std::int32_t>(here.tile.x()) - static_cast<std::int32_t>(m.first().x());
                if (c < 0 || c >= static_cast<std::int32_t>(parcel_columns)) return;
                waiting[waiting.size() - 1] = waiting[turning]; // it joins those that turn
                waiting[turning++] = rest;
            };
            if constexpr (Access::on_host)
                if (arrived.size() <= ahead.limit - ahead.n) return pass_row(arrived, d, keep);
            for (Message const& m : arrived)
                if (std::uint32_t const owed = serve_row(m, d); owed != 0) keep(m, owed);
        }
        /// Serves the arrivals of a row, for a host, if there is room ahead for all. `keep(m, owed)` takes a parcel that waits for a column.
        template <class Arrived, class Keep>
        TILEMESH_KERNEL void pass_row(Arrived const& all, Direction d, Keep const& keep) noexcept
        {
            Way& w = way[index(d)];
            Message* next = w.parcels + w.n;
            std::uint32_t const x = here.tile.x();
            constexpr std::uint32_t part = 64;
            Message const* turns[part];
            for (Message const *m = all.begin(), *const end = all.end(); m != end;) {
                std::uint32_t n = 0; // no branch: a predictor cannot know the tiles
                for (Message const* const stop = end - m < part ? end : m + part; m != stop; ++m) {
                    std::uint32_t const c = x - m->first().x(); // wraps west of its columns
                    // The tiles that it names lie ahead, or in this column.
                    std::uint32_t const mine = m->to & 0xffu << 8 * (c % parcel_columns) & all_if_below(c, parcel_columns), rest = m->to ^ mine;
                    turns[n] = m;
                    n += mine != 0 ? 1u : 0u;
                    *next = *m;
                    next->to = rest;
                    next += rest != 0 ? 1 : 0;
                }
                for (std::uint32_t i = 0; i < n; ++i)
                    if (std::uint32_t const owed = serve_column(*turns[i], x - turns[i]->first().x(), turns[i]->to); owed != 0) keep(*turns[i], owed);
            }
            w.n = static_cast<std::uint32_t>(next - w.parcels);
        }
    };

    /// Sends parcels of the tile's own records on one way while there is room. Returns whether some are left.
    template <class Frame, class Windows>
    static bool send_own(Tile& tile, std::uint32_t way, Frame const& frame, Home<P> const& home, Seen<P> const& seen, Offers const& offers,
                         Windows const& windows, Sending& sending) noexcept
    {
        std::uint32_t const x = tile.here.tile.x(), n = offers.size();
        std::uint32_t const first = way == 0 ? 0 : way == 1 ? x + 1 : x, end = way == 0 ? x : way == 1 ? 0xffffffffu : x + 1; // its columns
        std::uint32_t record = sending.record[way], part = sending.part[way];
        // The parcel at which the pass before ended on this way still waits for room. Most passes need not look at it.
        if (way == own_column && sending.rest != 0 && offers[record].parts == 1) {
            TileId const parcel_first = offers[record].first;
            if (tile.column_is_full(parcel_first, x - parcel_first.x(), sending.rest)) return true;
        }
        if (way != own_column && (record | part) != 0 && record < n && !tile.room(row[way])) return true;
        for (; record < n; ++record, part = 0) {
            Offered const& offer = offers[record];
            if (offer.parts == 0) continue;
            if (offer.parts == 1) {
                auto const c0 = static_cast<std::int32_t>(first) - static_cast<std::int32_t>(offer.first.x());
                std::uint32_t const to = way == 0   ? detail::columns_before(offer.to, static_cast<std::int32_t>(x) -
                                                                                           static_cast<std::int32_t>(offer.first.x()))
                                         : way == 1 ? detail::columns_after(offer.to, c0 - 1)
                                                    : detail::columns_after(offer.to, c0 - 1) & ~detail::columns_after(offer.to, c0);
                if (to == 0) continue;
                Splat const& s = Access::splat_of(frame, seen[record]);
                if (!send_part(tile, way, Message::make(seen[record], s, home[record].id, offer.first, to), sending)) break;
                continue;
            }
            Splat const& s = Access::splat_of(frame, seen[record]);
            detail::Wanted const wanted(s, frame.fold, frame.view.camera, windows);
            std::uint32_t const parts = wanted.parts();
            for (; part < parts; ++part) {
                std::uint32_t const to = wanted.tiles(part, first, end);
                if (to != 0 && !send_part(tile, way, Message::make(seen[record], s, home[record].id, wanted.first(part), to), sending)) break;
            }
            if (part < parts) break;
        }
        sending.record[way] = record;
        sending.part[way] = part;
        return record < n;
    }
    /// Sends one parcel on one way; false if something of it is left.
    TILEMESH_KERNEL static bool send_part(Tile& tile, std::uint32_t way, Message const& m, Sending& sending) noexcept
    {
        bool const begun = way == own_column && sending.rest != 0;
        if (way == own_column)
            sending.rest = tile.serve_column(m, tile.here.tile.x() - m.first().x(), begun ? sending.rest : m.to);
        else if (!tile.room(row[way]))
            return false;
        else
            tile.send(m, row[way], m.to);
        if (!begun) {
            ++tile.counts.sent;
            tile.counts.asked += detail::bits_in(m.to);
        }
        return way != own_column || sending.rest == 0;
    }
};

}}} // namespace tilemesh::splat::homes
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
