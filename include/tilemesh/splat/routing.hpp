#pragma once
#include <tilemesh/splat/contribution.hpp>
#include <tilemesh/splat/policies.hpp>

/// Moves every record to its anchor tile, by one tile a superstep.
///
/// The protocol with `Hold`. The rule is dimension-ordered: a record goes along the first axis, then along the second axis, and never back.
/// Let c be the slots of a channel end, and q the slots of a FIFO.
///   1. Second-leg arrivals go first; they never wait. At most c records arrive on a side. Each either goes straight on to the opposite side,
///      whose channel is empty when compute begins, or sinks. A sink always accepts: the record goes into storage, or if storage is full, out of
///      the machine as `unplaced` (it is counted, and the host knows its id).
///   2. First-leg arrivals may find no room ahead. They wait in the FIFO of their side, which is served before new arrivals.
///   3. A tile tells each first-leg neighbour the fill of the FIFO on that side, as the note of the channel back. It sends to a first-leg
///      neighbour at most q - (the fill it was told) - (its number of records sent in the superstep before) records, and at most c.
///   4. A tile's own records leave last.
///
/// No record that was sent is lost. The fill told at superstep t is the fill after compute t. Records sent at t arrive at t + 1 and add at
/// most `sent(t)`. Records sent at t + 1 arrive at t + 2. So the fill after t + 2 is at most fill(t) + sent(t) + sent(t + 1) <= q. A tile
/// with a waiting record votes busy, so a fill that is not told is 0. A tile that sent votes busy, so its count of sent records is one
/// superstep old whenever it runs.
///
/// There is no deadlock. Second-leg records never wait, so their channels empty in a bounded number of supersteps. A first-leg FIFO waits
/// for a second-leg channel, or for the next FIFO in the same direction. Directions end at the edge, so this relation has no cycle.
///
/// A record may have to turn back only if a bound cut the last frame and the view changed. Such a record never waits in a FIFO or on the
/// second leg: it goes on, or becomes a record of the tile it is on, or is unplaced if that tile is full. Hence each superstep in which
/// records are under way moves at least one record, for any capacities c, q >= 1 and any order of arrival. tests/splat/routing.cpp tests
/// the protocol with capacity 1, exhaustively on small grids.
///
/// Cost: without a full channel, W + H - 2 exchanges and one more pass from any placement. Each hop sends one record's bytes.
namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace detail {
/// How many records each side may take in a superstep, and whether that is less than a channel's slots for want of credit.
struct Room {
    std::uint32_t limit[4];
    bool short_of_credit[4];
};

/// The handling of one record by routing, for any saturation policy.
template <class S>
struct RouteStep {
    using Record = typename S::Record;
    using Message = RoadMessage<S>;
    using Rule = typename S::Routing;
    using Access = AccessOf<S>;
    static_assert(is_dimension_ordered<Rule>(),
                  "this routing rule is not dimension-ordered (it may turn back from its second leg, so FIFOs and credits on "
                  "the first leg do not prevent dead-lock); go along one axis until the coordinate fits, then the other");

    Here const& here;
    typename S::Parameters const& frame;
    Storage<S>& storage;
    Marks<S>& marks;
    Splats<S>& splats;
    Counts& counts;
    LookupOf<S>& lookup;

    /// Is this tile the anchor of the message's record? Sets `anchor`. It projects the record if the message has no anchor or an outdated
    /// one.
    bool is_home(Message const& m, TileId& anchor) const noexcept
    {
        if (S::Addressing::carried_in(frame) && frame.readdress == 0) {
            anchor = S::Addressing::anchor(m);
            return anchor == here.tile;
        }
        auto const entry = Access::project(S::Addressing::record(m), frame);
        Splat const& s = Access::splat_of(frame, entry);
        ++counts.projected;
        anchor = s.anchor;
        return !s.visible() || s.anchor == here.tile; // a record with nothing on screen stays where it is
    }
    /// The slot of the copy that the tile has of a record, or `no_slot`. Without bloom there are no copies.
    std::uint32_t copy_of(Record const& g) const noexcept
    {
        return blooms_in<S>(frame) ? lookup.slot_of(here, frame, marks, splats.begin(), g) : no_slot;
    }
    /// Puts a record into storage; false if storage is full. If the tile already has a copy of it, the copy becomes the anchored record.
    bool settle(Record const& g) const noexcept { return settle(g, copy_of(g)); }
    bool settle(Record const& g, std::uint32_t i) const noexcept
    {
        auto const entry = Access::project(g, frame);
        ++counts.projected;
        if constexpr (may_rank<typename S::Saturation>)
            if (i != no_slot && marks[i].id != g.id) i = no_slot; // another record took its place in this pass
        if (i != no_slot) {
            storage[i] = g;
            splats[i] = entry;
            marks[i].bits = (marks[i].bits & ~Mark::copy) | Mark::owes;
            ++counts.changes;
            return true;
        }
        if (!storage.try_push(g)) {
            if constexpr (may_rank<typename S::Saturation>)
                if (ranks_in<S>(frame))
                    return take_place<S>(here, frame, storage, marks, splats, counts, lookup, g, entry,
                                         blooms_in<S>(frame) ? Mark::owes : 0) != no_slot;
            ++counts.storage_full;
            return false;
        }
        marks.unchecked_push({g.id, blooms_in<S>(frame) ? Mark::owes : 0});
        splats.unchecked_push(entry);
        lookup.add(entry);
        ++counts.changes;
        return true;
    }
    /// Settles the records of n messages. A full storage is counted; the record is unplaced.
    void settle_all(Message const* const* messages, std::uint32_t n) const noexcept
    {
        std::uint32_t copies[at_once];
        for (std::uint32_t k = 0; k < n; ++k) {
            copies[k] = copy_of(S::Addressing::record(*messages[k]));
            if (copies[k] != no_slot) Access::about_to_change(marks[copies[k]]);
        }
        for (std::uint32_t k = 0; k < n; ++k) (void)settle(S::Addressing::record(*messages[k]), copies[k]);
    }
    static constexpr std::uint32_t at_once = 16; ///< of settle_all
    /// Keeps a record that cannot go on as one of the tile's own, which leaves later; false if storage is full.
    bool keep(Record const& g, FlowControl& flow) const noexcept
    {
        auto const before = storage.size();
        if (!settle(g)) return false;
        auto const i = storage.size() > before ? before : lookup.slot_of(here, frame, marks, splats.begin(), g);
        TileId const anchor = Access::splat_of(frame, splats[i]).anchor;
        marks[i].bits |= Mark::leaving | Mark::leaves(Rule::towards(here.tile, anchor));
        ++flow.leaving;
        return true;
    }
    /// Sends slot i's record on its way. If the footprint still touches this tile and the setup blooms, a copy stays.
    template <class Side>
    void depart(std::uint32_t i, Side& out) const noexcept
    {
        out.unchecked_push(S::Addressing::make(storage[i], Access::anchor_of(frame, splats[i])));
        ++counts.hops;
        ++counts.changes;
        if (blooms_in<S>(frame) && Access::is_here(here, frame, splats[i]))
            marks[i].bits = (marks[i].bits | Mark::copy) & ~(Mark::leaving | Mark::leaves_any);
        else
            remove_slot(storage, marks, splats, i);
    }
    /// Sends the records that cover most, as far as each side has room for all records of an octave. Closes the sides that are full.
    template <class Outs>
    void depart_largest(Outs& out, Room const& room, FlowControl& flow, std::uint32_t& open) const noexcept
    {
        SideCuts cuts;
        for (std::uint32_t i = 0, n = marks.size(); i < n; ++i)
            if (marks[i].is(open)) cuts.add(marks[i].leaves_on(), SideCuts::octave_of(Access::splat_of(frame, splats[i])));
        for (Direction d : news) cuts.close(d, (open & Mark::leaves(d)) != 0 ? room.limit[index(d)] - out[d].size() : 0);
        for (std::uint32_t i = marks.size(); i-- > 0;) {
            if (!marks[i].is(open)) continue;
            Direction const d = marks[i].leaves_on();
            if (!cuts.has_room(d, SideCuts::octave_of(Access::splat_of(frame, splats[i])))) continue;
            depart(i, out[d]);
            --flow.leaving;
        }
        for (Direction d : news)
            if (out[d].size() >= room.limit[index(d)]) open &= ~Mark::leaves(d);
    }
    /// After records took the places of others: how many are leaving.
    void count_leaving(FlowControl& flow) const noexcept
    {
        flow.leaving = 0;
        for (std::uint32_t i = 0, n = marks.size(); i < n; ++i) flow.leaving += marks[i].is(Mark::leaving) ? 1u : 0u;
    }
    /// Sends the leaving records for which there is room, and counts the others as refused. It looks at marks only, 16 at once, and at the
    /// records that it sends.
    template <class Outs>
    void depart_all(Outs& out, Room const& room, FlowControl& flow) const noexcept
    {
        std::uint32_t open = 0, short_of_credit = 0; // sides, as bits of marks
        for (Direction d : news) {
            if (out[d].size() < room.limit[index(d)]) open |= Mark::leaves(d);
            if (room.short_of_credit[index(d)]) short_of_credit |= Mark::leaves(d);
        }
        if constexpr (may_rank<typename S::Saturation>)
            if (ranks_in<S>(frame)) depart_largest(out, room, flow, open);
        // From the last slot to the first, a few at a time. A slot that is removed is taken by the last one, which was looked at before.
        std::uint32_t slots[2 * at_once];
        for (std::uint32_t end = storage.size(); open != 0 && end != 0;) {
            std::uint32_t const n = list_down_with_bits(marks.begin(), end, open, slots, 2 * at_once);
            for (std::uint32_t k = 0; k < n; ++k) Access::about_to_send(frame, splats[slots[k]], storage[slots[k]]);
            for (std::uint32_t k = 0; k < n; ++k) {
                std::uint32_t const i = slots[k];
                if (!marks[i].is(open)) continue; // this side became full
                Direction const d = marks[i].leaves_on();
                depart(i, out[d]);
                --flow.leaving;
                if (out[d].size() == room.limit[index(d)]) open &= ~Mark::leaves(d);
            }
        }
        if (flow.leaving == 0) return;
        std::uint32_t no_credit = 0;
        for (std::uint32_t i = 0, n = short_of_credit != 0 ? marks.size() : 0; i < n; ++i)
            no_credit += (marks[i].bits & short_of_credit) != 0 ? 1u : 0u;
        counts.no_credit += no_credit;
        counts.channel_full += flow.leaving - no_credit;
    }
};

/// Is this tile the end of the message's journey? As RouteStep::is_home, without counting.
template <class S>
bool ends_here(Here const& here, typename S::Parameters const& frame, RoadMessage<S> const& m) noexcept
{
    if (S::Addressing::carried_in(frame) && frame.readdress == 0) return S::Addressing::anchor(m) == here.tile;
    auto const entry = AccessOf<S>::project(S::Addressing::record(m), frame);
    Splat const& s = AccessOf<S>::splat_of(frame, entry);
    return !s.visible() || s.anchor == here.tile;
}

/// The operations of Route, for a cost model. An arrival is taken, and projected if it does not carry its anchor. A record that arrives at
/// its anchor tile is projected and looked up among the tile's records (`find` looks at all of them); at least as many records do so as
/// arrive and do not go on. A departure is given to a channel.
///
/// An arrival at its anchor tile settles, even if storage has no room for it. The count is exact, with one exception: a record that a bound
/// left waiting in a FIFO, and for which a new view makes this tile the anchor, settles without being counted.
template <class S>
struct RouteOperations {
    static Operations operations(Here here, Broadcast<typename S::Parameters> frame, Marks<S> const& marks, In<Road<S>> in,
                                 Out<Road<S>> out) noexcept
    {
        std::uint32_t arrived = 0, left = 0, settled = 0;
        for (Direction d : news) {
            arrived += in[d].size();
            left += out[d].size();
            for (auto const& m : in[d]) settled += ends_here<S>(here, *frame, m) ? 1 : 0;
        }
        std::uint32_t const home = arrived > left ? arrived - left : 0;
        // To find its own records that leave, the tile looks at all marks.
        std::uint32_t const own = left > arrived ? left - arrived : 0;
        Operations o;
        o[Operation::routed] = arrived + left;
        o[Operation::projection] = projections_through(frame->view.camera, S::Addressing::carried_in(*frame) ? home : arrived);
        o[Operation::slot] = times(home + (own != 0 ? 1 : 0), marks.size());
        o.settled_bytes = times(settled, AccessOf<S>::template road_bytes<RoadMessage<S>>(*frame));
        return o;
    }
};
/// Route on one tile, with `Hold`.
template <class S>
struct HoldingRoute {
    using Message = RoadMessage<S>;
    using Rule = typename S::Routing;
    using Access = AccessOf<S>;

    TILEMESH_KERNEL static Vote run(RouteStep<S> const& step, Broadcast<typename S::Parameters> frame, Waiting<S, 0>& waiting0,
                                    Waiting<S, 1>& waiting1, FlowControl& flow, In<Road<S>> const& in, Out<Road<S>>& out) noexcept
    {
        Here const& here = step.here;
        Counts& counts = step.counts;

        // The number of records that each side may take: the free slots, and on the first leg also the credit of the FIFO behind the
        // channel.
        Room most{};
        for (Direction d : news) most.limit[index(d)] = out[d].capacity();
        for (std::uint32_t leg = 0; leg < 2; ++leg) {
            Direction const d = Rule::first_leg[leg];
            std::uint32_t const used = in[d].note() + flow.sent[leg];
            std::uint32_t const behind = leg == 0 ? waiting1.capacity() : waiting0.capacity(); // of the FIFO there
            std::uint32_t const credit = used < behind ? behind - used : 0;
            if (credit < most.limit[index(d)]) {
                most.limit[index(d)] = credit;
                most.short_of_credit[index(d)] = true;
            }
        }
        auto const room = [&](Direction d) noexcept {
            if (out[d].size() < most.limit[index(d)]) return true;
            ++counts.refusals(most.short_of_credit[index(d)]);
            return false;
        };
        // Of the messages that carry anchors of this view, those that end here are collected and settled a few at a time: two messages never
        // bring one record.
        bool const addressed = S::Addressing::carried_in(*frame) && frame->readdress == 0;
        Message const* home[RouteStep<S>::at_once];
        std::uint32_t homes = 0;
        auto const settle_homes = [&]() noexcept {
            step.settle_all(home, homes);
            homes = 0;
        };
        auto const go = [&](Message const& m) noexcept {
            TileId anchor;
            if (step.is_home(m, anchor)) {
                settle_homes();
                (void)step.settle(S::Addressing::record(m)); // a full storage is counted; the record is unplaced
                return true;
            }
            Direction const d = Rule::towards(here.tile, anchor);
            if (!room(d)) return false;
            out[d].unchecked_push(S::Addressing::make(S::Addressing::record(m), anchor));
            ++counts.hops;
            return true;
        };
        // Sends on or settles the messages from number i on that go straight on or end here, as nearly all do. Returns the number of the first
        // one that does neither, or has no room; n if there is none.
        auto const go_on = [&](auto const& from, std::uint32_t i, std::uint32_t n, Direction d) noexcept {
            if (!addressed) return i;
            std::uint32_t used = out[d].size();
            std::uint32_t const before = used, limit = most.limit[index(d)];
            for (; i < n; ++i) {
                Message const& m = from[i];
                TileId const anchor = S::Addressing::anchor(m);
                if (anchor == here.tile) {
                    Access::about_to_find(*frame, S::Addressing::record(m));
                    home[homes++] = &m;
                    if (homes == RouteStep<S>::at_once) settle_homes();
                    continue;
                }
                if (used >= limit || Rule::towards(here.tile, anchor) != d) break;
                out[d].begin()[used++] = m;
            }
            if (used != before) out[d].resize(used);
            counts.hops += used - before;
            return i;
        };
        // A record that was under way when the view changed may have to turn back. Two such records in FIFOs could wait for each other for
        // ever, so the record becomes one of this tile's own instead.
        auto const turns_back = [&](Message const& m, Direction from) noexcept {
            if (frame->readdress == 0) return false;
            auto const entry = Access::project(S::Addressing::record(m), *frame);
            return Rule::towards(here.tile, Access::splat_of(*frame, entry).anchor) == from;
        };
        auto const empty_fifo = [&](auto& waiting, auto const& arrived, Direction from) noexcept {
            std::uint32_t kept = 0;
            for (std::uint32_t i = 0, n = waiting.size(); i < n; ++i) {
                if (go(waiting[i])) continue;
                if (turns_back(waiting[i], from)) {
                    (void)step.keep(S::Addressing::record(waiting[i]), flow);
                    continue;
                }
                if (kept != i) waiting[kept] = waiting[i];
                ++kept;
            }
            waiting.truncate(kept);
            for (std::uint32_t i = 0, n = arrived.size(); i < n; ++i) {
                i = go_on(arrived, i, n, opposite(from));
                if (i == n) break;
                Message const& m = arrived[i];
                if (go(m)) continue;
                if (turns_back(m, from))
                    (void)step.keep(S::Addressing::record(m), flow);
                else if (!TILEMESH_EXPECT(waiting.try_push(m), "a FIFO was sent more than its credit (flow control is broken); "
                                                               "report this"))
                    ++counts.storage_full;
            }
        };

        // The second leg first: it cannot block anything. Only a record that was under way when the view changed (a bound cut the frame
        // before) may have to turn and find no room. Then it becomes one of this tile's own.
        for (Direction d : news)
            if (d != Rule::first_leg[0] && d != Rule::first_leg[1])
                for (std::uint32_t i = 0, n = in[d].size(); i < n; ++i) {
                    i = go_on(in[d], i, n, opposite(d));
                    if (i == n) break;
                    if (!go(in[d][i])) (void)step.keep(S::Addressing::record(in[d][i]), flow);
                }
        empty_fifo(waiting0, in[Rule::first_leg[0]], Rule::first_leg[0]);
        empty_fifo(waiting1, in[Rule::first_leg[1]], Rule::first_leg[1]);
        settle_homes();
        if constexpr (may_rank<typename S::Saturation>)
            if (ranks_in<S>(*frame)) step.count_leaving(flow);
        if (flow.leaving != 0) step.depart_all(out, most, flow);

        out[Rule::first_leg[0]].set_note(waiting0.size());
        out[Rule::first_leg[1]].set_note(waiting1.size());
        for (std::uint32_t leg = 0; leg < 2; ++leg) flow.sent[leg] = out[Rule::first_leg[leg]].size();
        flow.waiting = waiting0.size() + waiting1.size();
        bool const quiet =
            flow.leaving == 0 && flow.waiting == 0 && flow.sent[0] == 0 && flow.sent[1] == 0;
        return quiet ? Vote::quiet : Vote::busy;
    }
};

/// Route on one tile, with `Drop`.
template <class S>
struct DroppingRoute {
    using Message = RoadMessage<S>;
    using Rule = typename S::Routing;

    TILEMESH_KERNEL static Vote run(RouteStep<S> const& step, FlowControl& flow, In<Road<S>> const& in, Out<Road<S>>& out) noexcept
    {
        Here const& here = step.here;
        Counts& counts = step.counts;
        auto const room = [&](Direction d) noexcept {
            if (out[d].size() < out[d].capacity()) return true;
            ++counts.channel_full;
            return false;
        };
        for (Direction from : news)
            for (Message const& m : in[from]) {
                TileId anchor;
                if (step.is_home(m, anchor)) {
                    (void)step.settle(S::Addressing::record(m));
                    continue;
                }
                Direction const d = Rule::towards(here.tile, anchor);
                if (room(d)) {
                    out[d].unchecked_push(S::Addressing::make(S::Addressing::record(m), anchor));
                    ++counts.hops;
                } else {
                    (void)step.keep(S::Addressing::record(m), flow);
                }
            }
        if constexpr (may_rank<typename S::Saturation>)
            if (ranks_in<S>(step.frame)) step.count_leaving(flow);
        if (flow.leaving != 0) {
            Room most{};
            for (Direction d : news) most.limit[index(d)] = out[d].capacity();
            step.depart_all(out, most, flow);
        }
        return flow.leaving == 0 ? Vote::quiet : Vote::busy;
    }
};
} // namespace detail

namespace kernel {
template <class P>
struct Route : detail::RouteOperations<P> {
    static constexpr char const* name = "route";
    static constexpr bool may_hold = P::Saturation::may_hold;

    Vote operator()(Here here, Broadcast<typename P::Parameters> frame, Storage<P>& storage, Marks<P>& marks, Splats<P>& splats,
                    OnlyIf<may_hold, Waiting<P, 0>&> waiting0, OnlyIf<may_hold, Waiting<P, 1>&> waiting1, FlowControl& flow, Counts& counts,
                    In<Road<P>> in, Out<Road<P>> out) const noexcept
    {
        detail::LookupOf<P> lookup;
        detail::RouteStep<P> const step{here, *frame, storage, marks, splats, counts, lookup};
        if constexpr (may_hold)
            if (P::Saturation::holds_in(*frame)) return detail::HoldingRoute<P>::run(step, frame, waiting0, waiting1, flow, in, out);
        return detail::DroppingRoute<P>::run(step, flow, in, out);
    }
};
} // namespace kernel
/// Moves every record by one tile towards its anchor tile. With the saturation policy `Drop`, the kernel has no FIFOs.
template <class S>
using Route = kernel::Route<PoliciesOf<S>>;

}}} // namespace tilemesh::splat
