#pragma once
#include <cstdint>
#include <tilemesh/splat/fitted.hpp>
#include <tilemesh/splat/routing.hpp>

/// Routing over other links than those of the mesh: around a torus, and over express links that skip tiles. Both are routing rules of a
/// setup: `struct Mine : splat::Lossless { using Routing = splat::Torus; };`. Records go other ways to the same anchor tiles, so a picture
/// from which nothing is missing has the bits of the mesh. Bloom stays on the links of the mesh.
///
/// The protocol, with `Hold`. A record goes along the row to its column, then along the column, and never back. Each of its steps is the
/// longest that does not pass the goal; if the express link has no room, the step is that of the mesh. A tile has eight FIFOs, two lanes
/// for each side from which records arrive:
///   torus     lane 1 for records that still have to cross an edge of the grid in this direction, lane 0 for the others
///   express   lane 1 for records that came over an express link, lane 0 for the others
/// A record that cannot go on waits in the FIFO of its side and lane. A tile sends to a FIFO at most its slots, less the fill that the
/// neighbour told it, less what it sent to this FIFO in the superstep before. So no FIFO overflows (routing.hpp has the proof), and no
/// record that was sent is lost. A record at its anchor tile never waits: it goes into storage, or out of the machine as `unplaced`.
///
/// There is no deadlock, for all slots >= 1. Order the FIFOs: those of a row before those of a column; of one direction lane 1 of a torus
/// before lane 0; then by the place in that direction, from the last edge that was crossed. A record waits only for FIFOs that are later in
/// this order: it moves on in its direction, crosses the edge from lane 1 to lane 0 and never again (its way is at most half a ring), or
/// turns from the row to the column. Hence there is no cycle. Of all FIFOs with records take the last one: the FIFOs for which its records
/// wait are empty, and say so in the next superstep, so credit returns. Channels are empty when compute begins. So some record moves, and
/// each move brings a record nearer to its goal.
///
/// A bound may cut a frame. Then records under way may have new goals, and a record may have to turn back. In such a frame no record
/// waits in a FIFO: a record that cannot go on becomes a record of the tile it is on, or is `unplaced` if that tile is full.
///
/// Cost: six FIFOs more than the mesh; express links also have eight channel ends more, with the slots of `Road`. Each tile has them,
/// whether its column or row has express links or not. A torus has as many ends as the mesh. Without a full channel, routing takes
/// W / 2 + H / 2 exchanges at most on a torus.
namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace kernel {
template <class P>
struct RouteLanes;
}

/// The next step of a record: the side on which it leaves a tile, and the lane of the FIFO that may hold it on the next tile.
struct Hop {
    Direction side;
    std::uint32_t lane;
};

/// Rows and columns are rings: the links at an edge of the grid go to the opposite edge. A record takes the shorter way, of equal ones that
/// to the east or south.
struct Torus : RowFirst {
    static constexpr char const* name = "torus";
    static constexpr Edge edge = Edge::wrap;
    static constexpr std::uint32_t fifos = 8;
    template <class P>
    using Kernel = kernel::RouteLanes<P>;
    using RowFirst::towards;
    static constexpr Direction towards(Grid grid, TileId from, TileId to) noexcept // from != to
    {
        if (to.x() != from.x()) return 2 * around(from.x(), to.x(), grid.width) <= grid.width ? Direction::east : Direction::west;
        return 2 * around(from.y(), to.y(), grid.height) <= grid.height ? Direction::south : Direction::north;
    }
    static constexpr Hop hop(Grid grid, TileId from, TileId to) noexcept
    {
        Direction const side = towards(grid, from, to);
        return {side, lane_at(grid.neighbour(from, side, edge), side, to)};
    }
    /// The lane of a record that goes towards `side` on tile `at`.
    static constexpr std::uint32_t lane_at(TileId at, Direction side, TileId to) noexcept
    {
        bool const crosses = side == Direction::east    ? to.x() < at.x()
                             : side == Direction::west  ? to.x() > at.x()
                             : side == Direction::south ? to.y() < at.y()
                                                        : to.y() > at.y();
        return crosses ? 1 : 0;
    }

private:
    static constexpr std::uint32_t around(std::uint32_t from, std::uint32_t to, std::uint32_t n) noexcept
    {
        return to >= from ? to - from : to + n - from;
    }
};

/// Tiles whose column is a multiple of `Distance` have links along their row to the next such tiles; rows and columns likewise. A record
/// takes an express link where it stands at one and it does not pass its column or row.
template <std::uint32_t Distance>
struct ExpressLinks : RowFirst {
    static_assert(Distance >= 2, "express links that skip no tile (the mesh has those); give a distance of 2 or more");
    static constexpr char const* name = "express";
    static constexpr std::uint32_t distance = Distance;
    static constexpr std::uint32_t fifos = 8;
    template <class P>
    using Kernel = kernel::RouteLanes<P>;
    static constexpr Hop hop(Grid, TileId from, TileId to) noexcept
    {
        Direction const side = towards(from, to);
        bool const row = side == Direction::east || side == Direction::west;
        std::uint32_t const at = row ? from.x() : from.y(), goal = row ? to.x() : to.y();
        return {side, at % Distance == 0 && (goal > at ? goal - at : at - goal) >= Distance ? 1u : 0u};
    }
};

/// What a tile sent to each FIFO of its neighbours in the previous pass: two lanes a side, in the order of `news`.
struct LaneFlow {
    static constexpr char const* name = "credits of lanes";
    std::uint32_t sent[8];
};

namespace detail {
/// Is it a policy by type that ranks? A policy by words may rank; those words are those of a setup by value, which has the same check.
template <class Saturation>
inline constexpr bool always_ranks = region::always_holds<Saturation> && may_rank<Saturation>;
/// The operations of RouteLanes: those of Route, over both kinds of links.
template <class S>
struct LaneOperations {
    static constexpr bool express = express_distance<typename S::Routing> != 1;
    static Operations operations(Here here, Broadcast<typename S::Parameters> frame, Marks<S> const& marks, In<Road<S>> in,
                                 Out<Road<S>> out, OnlyIf<express, In<Express<S>>> far_in,
                                 OnlyIf<express, Out<Express<S>>> far_out) noexcept
    {
        std::uint32_t arrived = 0, left = 0, settled = 0;
        auto const add = [&](auto const& from, auto const& to) noexcept {
            arrived += from.size();
            left += to.size();
            for (auto const& m : from) settled += ends_here<S>(here, *frame, m) ? 1 : 0;
        };
        for (Direction d : news) {
            add(in[d], out[d]);
            if constexpr (express) add(far_in[d], far_out[d]);
        }
        return RouteOperations<S>::of(*frame, arrived, left, settled, marks.size());
    }
};

/// Route over lanes on one tile.
template <class S>
struct LaneRoute {
    using Message = RoadMessage<S>;
    using Rule = typename S::Routing;
    using Access = AccessOf<S>;
    static constexpr bool express = express_distance<Rule> != 1;
    using FarIn = OnlyIf<express, In<Express<S>>>;
    using FarOut = OnlyIf<express, Out<Express<S>>>;

    RouteStep<S> const& step;
    typename S::Parameters const& frame;
    In<Road<S>> const& in;
    Out<Road<S>>& out;
    FarIn const& far_in;
    FarOut& far_out;
    std::uint32_t credit[8] = {}, sent[8] = {};

    static constexpr std::uint32_t number(Direction side, std::uint32_t lane) noexcept { return 2 * index(side) + lane; }
    /// The slots of a FIFO that are used. Two fills share a note of a torus.
    static std::uint32_t slots_of(std::uint32_t capacity) noexcept { return capacity < 0xffffu ? capacity : 0xffffu; }

    void count_credit(std::uint32_t fifo_slots, LaneFlow const& before) noexcept
    {
        for (Direction d : news)
            for (std::uint32_t lane = 0; lane < 2; ++lane) {
                std::uint32_t told = in[d].note() >> 16 * lane & 0xffffu;
                if constexpr (express)
                    if (lane == 1) told = far_in[d].note();
                std::uint32_t const used = told + before.sent[number(d, lane)];
                credit[number(d, lane)] = used < fifo_slots ? fifo_slots - used : 0;
            }
    }
    /// Calls f with the outgoing end of a hop. The ends of the two channels have types of their own.
    template <class F>
    auto on_end(Hop hop, F const& f) noexcept
    {
        if constexpr (express)
            if (hop.lane == 1) return f(far_out[hop.side]);
        return f(out[hop.side]);
    }
    bool has_slot(Hop hop) noexcept
    {
        return on_end(hop, [](auto const& to) noexcept { return to.size() < to.capacity(); });
    }
    bool has_credit(Hop hop) const noexcept { return sent[number(hop.side, hop.lane)] < credit[number(hop.side, hop.lane)]; }
    bool has_room(Hop hop) noexcept { return has_slot(hop) && has_credit(hop); }
    /// The next hop of a record: by a shorter link in the same direction if the express link has no room.
    Hop hop_to(TileId anchor) noexcept
    {
        Hop const hop = Rule::hop(step.here.grid, step.here.tile, anchor);
        if constexpr (express)
            if (hop.lane == 1 && !has_room(hop)) return {hop.side, 0};
        return hop;
    }
    void refuse(Hop hop) noexcept { ++step.counts.refusals(has_slot(hop)); }

    /// Settles a record here or sends it on; false if it has to stay. Sets `anchor`.
    bool go(Message const& m, TileId& anchor) noexcept
    {
        if (step.is_home(m, anchor)) {
            (void)step.settle(S::Addressing::record(m)); // a full storage is counted; the record is unplaced
            return true;
        }
        Hop const hop = hop_to(anchor);
        if (!has_room(hop)) {
            refuse(hop);
            return false;
        }
        on_end(hop, [&](auto& to) noexcept { to.unchecked_push(S::Addressing::make(S::Addressing::record(m), anchor)); });
        ++sent[number(hop.side, hop.lane)];
        ++step.counts.hops;
        return true;
    }
    template <class Fifo>
    void empty(Fifo& fifo, FlowControl& flow) noexcept
    {
        std::uint32_t kept = 0;
        TileId anchor;
        for (std::uint32_t i = 0, n = fifo.size(); i < n; ++i) {
            if (go(fifo[i], anchor)) continue;
            if (frame.readdress != 0) {
                (void)step.keep(S::Addressing::record(fifo[i]), flow);
                continue;
            }
            if (kept != i) fifo[kept] = fifo[i];
            ++kept;
        }
        fifo.truncate(kept);
    }
    template <class Arrived, class Fifos>
    void take(Arrived const& arrived, Direction from, std::uint32_t far_lane, Fifos const& fifos, FlowControl& flow) noexcept
    {
        TileId anchor;
        for (Message const& m : arrived) {
            if (go(m, anchor)) continue;
            if (frame.readdress != 0) {
                (void)step.keep(S::Addressing::record(m), flow);
                continue;
            }
            std::uint32_t lane = far_lane;
            if constexpr (!express) lane = Rule::lane_at(step.here.tile, opposite(from), anchor);
            auto& fifo = *fifos[number(from, lane)];
            if (!TILEMESH_EXPECT(fifo.size() < slots_of(fifo.capacity()) && fifo.try_push(m),
                                 "a FIFO was sent more than its credit (flow control is broken); report this"))
                ++step.counts.storage_full;
        }
    }
    template <class Fifos>
    void serve(Direction from, Fifos const& fifos, FlowControl& flow) noexcept
    {
        for (std::uint32_t lane = 0; lane < 2; ++lane) empty(*fifos[number(from, lane)], flow);
        take(in[from], from, 0, fifos, flow);
        if constexpr (express) take(far_in[from], from, 1, fifos, flow);
    }
    /// Sends the tile's own records, as far as there is room.
    void depart_all(FlowControl& flow) noexcept
    {
        constexpr std::uint32_t at_once = 32;
        std::uint32_t slots[at_once], open = 0;
        auto const reopen = [&](Direction d) noexcept {
            open = has_room({d, 0}) || has_room({d, 1}) ? open | Mark::leaves(d) : open & ~Mark::leaves(d);
        };
        auto const hop_of = [&](std::uint32_t i) noexcept { return hop_to(Access::anchor_of(frame, step.splats[i])); };
        for (Direction d : news) reopen(d);
        for (std::uint32_t end = step.storage.size(); open != 0 && end != 0;) {
            std::uint32_t const n = list_down_with_bits(step.marks.begin(), end, open, slots, at_once);
            for (std::uint32_t k = 0; k < n; ++k) {
                Hop const hop = hop_of(slots[k]);
                if (!has_room(hop)) continue;
                on_end(hop, [&](auto& to) noexcept { step.depart(slots[k], to); });
                ++sent[number(hop.side, hop.lane)];
                --flow.leaving;
                reopen(hop.side);
            }
        }
        if (flow.leaving == 0) return;
        for (std::uint32_t i = 0, n = step.marks.size(); i < n; ++i)
            if (step.marks[i].is(Mark::leaving)) refuse(hop_of(i));
    }
    template <class Fifos>
    Vote run(Fifos const& fifos, FlowControl& flow, LaneFlow& lanes) noexcept
    {
        count_credit(slots_of(fifos[0]->capacity()), lanes);
        // Columns first: what they free is the goal of those that come along rows.
        for (Direction d : along_column) serve(d, fifos, flow);
        for (Direction d : along_row) serve(d, fifos, flow);
        if (flow.leaving != 0) depart_all(flow);

        flow.waiting = flow.sent[0] = flow.sent[1] = 0;
        for (Direction d : news) {
            std::uint32_t const near = fifos[number(d, 0)]->size(), far = fifos[number(d, 1)]->size();
            if constexpr (express) {
                out[d].set_note(near);
                far_out[d].set_note(far);
            } else {
                out[d].set_note(near | far << 16);
            }
            flow.waiting += near + far;
        }
        for (std::uint32_t i = 0; i < 8; ++i) flow.sent[0] += lanes.sent[i] = sent[i];
        return flow.leaving + flow.waiting + flow.sent[0] == 0 ? Vote::quiet : Vote::busy;
    }
};
} // namespace detail

namespace kernel {
template <class P>
struct RouteLanes : detail::LaneOperations<P> {
    static constexpr char const* name = "route";
    static constexpr bool express = detail::LaneOperations<P>::express;
    static_assert(P::Saturation::may_hold && !detail::always_ranks<typename P::Saturation>,
                  "a torus or express links with a saturation policy that drops or ranks records (its records wait in FIFOs, in the order "
                  "of arrival); give the setup the policy Hold");

    Vote operator()(Here here, Broadcast<typename P::Parameters> frame, Storage<P>& storage, Marks<P>& marks, Splats<P>& splats,
                    Waiting<P, 0>& waiting0, Waiting<P, 1>& waiting1, Waiting<P, 2>& waiting2, Waiting<P, 3>& waiting3,
                    Waiting<P, 4>& waiting4, Waiting<P, 5>& waiting5, Waiting<P, 6>& waiting6, Waiting<P, 7>& waiting7, FlowControl& flow,
                    LaneFlow& lanes, Counts& counts, In<Road<P>> in, Out<Road<P>> out, OnlyIf<express, In<Express<P>>> far_in,
                    OnlyIf<express, Out<Express<P>>> far_out) const noexcept
    {
        detail::LookupOf<P> lookup;
        detail::RouteStep<P> const step{here, *frame, storage, marks, splats, counts, lookup};
        Buffer<RoadMessage<P>>* const fifos[8] = {&waiting0, &waiting1, &waiting2, &waiting3, &waiting4, &waiting5, &waiting6, &waiting7};
        detail::LaneRoute<P> route{step, *frame, in, out, far_in, far_out};
        return route.run(fifos, flow, lanes);
    }
};
} // namespace kernel

/// The channel ends of a tile that routing has with a rule.
template <class Rule>
inline constexpr std::uint32_t road_ends = express_distance<Rule> == 1 ? 8 : 16;

/// Base's sizes for a rule of this header, in the SRAM that Base's channel of routing and its two FIFOs take: all ends and FIFOs get the
/// same slots.
template <class Base, class Rule>
constexpr Sizes sizes_of_links() noexcept
{
    constexpr auto words = frame_words<Base>();
    constexpr std::uint32_t lists = road_ends<Rule> + fifos_of<Rule>;
    Sizes sizes = Base::sizes;
    constexpr auto bytes = routing_bytes(Base::sizes, words, true) - sizeof(FlowControl) - sizeof(LaneFlow);
    sizes.road = sizes.waiting = slots_in(bytes - 8 * lists, lists * words.road_message);
    return sizes;
}
/// `Base` with routing over a torus or over express links, in the same SRAM. Example: `WithLinks<Lossless, ExpressLinks<4>>` has 83 slots
/// in each end and FIFO, in place of 200.
template <class Base, class Rule>
struct WithLinks : Base {
    using Routing = Rule;
    static constexpr Sizes sizes = sizes_of_links<Base, Rule>();
};

}}} // namespace tilemesh::splat
