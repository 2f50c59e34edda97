#pragma once
#include <tilemesh/splat/policies.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace detail {
/// The results of Project's pass over a tile.
struct Pending {
    std::uint32_t leaving; ///< records that wait to leave
    std::uint32_t owing;   ///< slots with Mark::owes
};
/// The state of a tile when a frame begins.
struct LastFrame {
    Pending pending;
    bool bloomed;          ///< bloom ran since routing brought records: only pending slots owe copies
    Counts counts;
};

/// Counts the anchored records, separately those with something on screen and those without. Needed only if routing may have brought or
/// taken records since the last count.
template <class S>
void count_anchored(typename S::Parameters const& frame, Marks<S> const& marks, Splats<S> const& splats, Counts& counts) noexcept
{
    counts.visible = counts.parked = 0;
    for (std::uint32_t i = 0, n = marks.size(); i < n; ++i)
        if (!marks[i].is(Mark::copy)) ++(AccessOf<S>::splat_of(frame, splats[i]).visible() ? counts.visible : counts.parked);
}

/// Updates a tile's records for a new view.
template <class S>
Pending begin_view(Here const& here, typename S::Parameters const& parameters, Storage<S>& storage, Marks<S>& marks,
                 Splats<S>& splats, Counts& counts, LastFrame const& last) noexcept
{
    using Access = AccessOf<S>;
    auto const& frame = Access::hold(parameters);
    Access::about_to_read(splats);
    Pending pending{0, 0};
    bool const reusable = S::Copies::reusable_in(frame), routes = routes_in<S>(frame), blooms = blooms_in<S>(frame);
    bool const forget = frame.resend_copies != 0 || (!reusable && frame.view_changed != 0);
    std::uint32_t visible = 0, parked = 0, kept = 0;
    [[maybe_unused]] std::uint32_t moved = 0, removed = 0, changes = 0;
    std::uint32_t const held = storage.size();
    // If nothing waits since the last frame, no mark says that a slot has something to do, and the anchored records are those that are no
    // copies. Then the tile need not look at its marks: it counts the changes.
    bool const rested = Access::knows_what_moved(frame) && routes && !forget && last.pending.leaving == 0 && last.pending.owing == 0 &&
                        last.bloomed && last.counts.changes == 0 && S::Saturation::holds_in(frame);
    if (!rested) Access::about_to_read(marks);
    // From the last slot to the first, a few at a time: first collect the slots that have something to do, without a branch that depends on
    // a record; then do it. Removing a slot moves the last slot to its place, and that one has been updated.
    constexpr std::uint32_t at_once = 64;
    std::uint32_t slots[2 * at_once];
    std::uint32_t own_before = 0, visible_before = 0; // of the anchored records that are looked at
    for (std::uint32_t end = held; end != 0;) {
        std::uint32_t n = 0;
        while (end != 0 && n <= at_once) {
            std::uint32_t const begin = end > at_once ? end - at_once : 0;
            if (rested) {
                for (std::uint32_t i = end; i-- > begin;) {
                    slots[n] = i;
                    n += Access::moved(frame, splats[i]);
                }
            } else if (routes && !forget) {
                for (std::uint32_t i = end; i-- > begin;) {
                    std::uint32_t const bits = marks[i].bits;
                    std::uint32_t row_state = 0;
                    std::uint32_t const settled = Access::is_settled(frame, splats[i], bits, row_state) ? 1u : 0u;
                    std::uint32_t const own = settled & ((bits & Mark::copy) != 0 ? 0u : 1u), shows = row_state & 1u;
                    visible += own & shows;
                    parked += own & ~shows;
                    slots[n] = i;
                    n += 1 - settled;
                }
            } else {
                for (std::uint32_t i = end; i-- > begin;) slots[n++] = i;
            }
            end = begin;
        }
        for (std::uint32_t k = 0; k < n; ++k) {
            Access::about_to_reach(frame, splats[slots[k]]);
            Access::about_to_change(marks[slots[k]]);
        }
        for (std::uint32_t k = 0; k < n; ++k) {
            std::uint32_t const i = slots[k];
            bool const copy = blooms && marks[i].is(Mark::copy);
            if (copy && !reusable) { // the tile has only the copy's splat, which is valid for one view
                if (forget) {
                    remove_slot(storage, marks, splats, i);
                    ++removed;
                }
                ++kept;
                continue;
            }
            [[maybe_unused]] std::uint32_t bits = marks[i].bits;
            auto const entry = [&]() noexcept {
                if constexpr (Access::entries_last)
                    return splats[i]; // without a look at the record
                else
                    return Access::project(storage[i], frame);
            }();
            Reach const r = Access::reach(here, frame, entry);
            if (copy && !r.here) {
                remove_slot(storage, marks, splats, i);
                ++removed;
                continue;
            }
            if (routes) // without routing, the host places the records and counts the changes
                if (!copy && Access::coverage_changed(here, frame, splats[i], r.here, bits)) ++changes;
            splats[i] = entry;
            if constexpr (S::blooms)
                if (blooms) {
                    std::uint32_t const wrong = (forget ? Mark::all_sides : ~r.sides & Mark::all_sides) |
                                                (frame.view_changed != 0 ? (bits & Mark::refused_any) >> 4 : 0u);
                    bits &= ~(wrong | wrong << 4 | Mark::owes);
                    if ((r.sides & ~bits) != 0 && (r.sides & child_sides(r.anchor, here.tile) & ~bits) != 0) {
                        bits |= Mark::owes;
                        ++pending.owing;
                    }
                }
            if (!copy) {
                if (routes) {
                    bool const goes = r.visible && !(r.anchor == here.tile);
                    if (goes && (bits & Mark::leaving) == 0) ++moved;
                    bits &= ~(Mark::leaving | Mark::leaves_any);
                    if (goes) bits |= Mark::leaving | Mark::leaves(S::Routing::towards(here.tile, r.anchor));
                    pending.leaving += goes ? 1 : 0;
                }
                std::uint32_t const shows = r.visible ? 1u : 0u;
                visible += shows;
                parked += 1u - shows;
                ++own_before;
                visible_before += Access::was_visible(frame, entry, shows);
            }
            if constexpr (S::routes || S::blooms)
                if (routes || blooms) marks[i].bits = bits;
        }
    }
    if (rested) {
        std::uint32_t const others_parked = last.counts.parked - (own_before - visible_before);
        parked += others_parked;
        visible += held - last.counts.copies - own_before - others_parked;
    }
    counts.visible = visible;
    counts.parked = parked;
    counts.projected = held - kept;
    if (routes) counts.moved = moved;
    if (routes || blooms) counts.changes += removed + changes;
    return pending;
}

/// Begins a frame on a tile. If the view did not change, the counts of leaving and owing records are those of the last frame (`last`).
template <class S>
Pending begin_frame(Here const& here, typename S::Parameters const& frame, Storage<S>& storage, Marks<S>& marks, Splats<S>& splats,
                  Counts& counts, LastFrame const& last) noexcept
{
    Counts const before = last.counts;
    counts = {};
    counts.copies = before.copies;
    counts.changes = before.changes;
    if (frame.view_changed != 0 || frame.resend_copies != 0) return begin_view<S>(here, frame, storage, marks, splats, counts, last);
    counts.visible = before.visible;
    counts.parked = before.parked;
    if (routes_in<S>(frame))
        if ((before.hops | before.projected) != 0 || ranks_in<S>(frame)) count_anchored<S>(frame, marks, splats, counts);
    return last.pending;
}
inline Vote vote_to_route(FlowControl& flow, std::uint32_t leaving) noexcept
{
    flow.leaving = leaving;
    return leaving + flow.waiting + flow.sent[0] + flow.sent[1] != 0 ? Vote::busy : Vote::quiet;
}
} // namespace detail

namespace kernel {
/// The operations of Project, for a cost model: it looks at every stored record, and projects the records that need it.
template <class S>
struct ProjectOperations {
    static Operations operations(Broadcast<typename S::Parameters> frame, Storage<S> const& storage, Counts const& counts) noexcept
    {
        Operations o;
        o[Operation::slot] = storage.size();
        o[Operation::projection] = projections_through(frame->view.camera, counts.projected);
        return o;
    }
};

template <class S>
struct Project : ProjectOperations<S> {
    static constexpr char const* name = "project";
    std::conditional_t<S::routes, Vote, void> operator()(Here here, Broadcast<typename S::Parameters> frame, Storage<S>& storage,
                                                         Marks<S>& marks, Splats<S>& splats, OnlyIf<S::routes, FlowControl&> flow,
                                                         OnlyIf<S::blooms, OwedCopies&> owed_copies, Counts& counts) const noexcept
    {
        detail::LastFrame last{{0, 0}, true, counts};
        [[maybe_unused]] bool const routes = routes_in<S>(*frame), blooms = blooms_in<S>(*frame);
        if constexpr (S::routes) last.pending.leaving = routes ? flow.leaving : 0;
        if constexpr (S::blooms) {
            last.pending.owing = blooms ? owed_copies.open : 0;
            last.bloomed = !blooms || owed_copies.first == 0;
        }
        [[maybe_unused]] auto const pending = detail::begin_frame<S>(here, *frame, storage, marks, splats, counts, last);
        if constexpr (S::blooms)
            if (blooms) owed_copies = {pending.owing, in_picture(here, *frame) ? 1u : 0u};
        if constexpr (S::routes) return routes ? detail::vote_to_route(flow, pending.leaving) : Vote::quiet;
    }
};

} // namespace kernel

/// Begins a frame on a tile. In a new view it projects all records of the tile (by reference, the host has projected them), marks the anchored
/// records that must leave and the slots that owe copies, and drops the copies whose footprint left the tile. If the view is that of the last frame,
/// it only resets the counters. It votes busy if a record must leave or waits.
///
/// After this pass, on every tile: a copy is present only if its footprint touches the tile. `Mark::shared(d)` is set only if the neighbour
/// on side d holds the record. A copy that a full channel refused is owed again in a new view. Two neighbours decide about a copy with the
/// same words and the same view, so dropping a copy needs no message. Cost: one projection per stored record in a new view, no projection
/// in an old one; no exchange. A setup without routing or bloom stores nothing for them.
template <class S>
using Project = kernel::Project<PoliciesOf<S>>;

}}} // namespace tilemesh::splat
