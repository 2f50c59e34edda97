#pragma once
#include <tilemesh/splat/contribution.hpp>
#include <tilemesh/splat/policies.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace kernel {
template <class S>
struct Bloom {
    static constexpr char const* name = "bloom";
    using Copies = typename S::Copies;
    using Access = AccessOf<S>;

    Vote operator()(Here here, Broadcast<typename S::Parameters> frame, Storage<S>& storage, Marks<S>& marks, Splats<S>& splats,
                    OwedCopies& owed_copies, Counts& counts, In<Beam<S>> in, Out<Beam<S>> out) const noexcept
    {
        bool const reusable = Copies::reusable_in(*frame), holds = S::Saturation::holds_in(*frame);
        // Sends slot i to the sides to which it is owed. Returns true if a copy is still owed.
        auto const send_owed = [&](std::uint32_t i, Reach const& r) noexcept {
            std::uint32_t bits = marks[i].bits & ~Mark::owes;
            std::uint32_t const owed = r.sides & child_sides(r.anchor, here.tile) & ~bits;
            if (owed != 0)
                for (Direction d : news) {
                    if ((owed & Mark::shared(d)) == 0) continue;
                    if (out[d].try_push(Copies::make(storage[i], Access::splat_of(*frame, splats[i])))) {
                        bits |= Mark::shared(d);
                    } else if (holds) {
                        ++counts.channel_full;
                        bits |= Mark::owes;
                    } else {
                        ++counts.copies_refused;
                        bits |= Mark::shared(d) | Mark::refused(d);
                    }
                }
            marks[i].bits = bits;
            return (bits & Mark::owes) != 0;
        };

        // Copies that were under way when the view changed. A projected copy shows the old view, and its sender has forgotten it. If the
        // host places the records, the sender's knowledge of its neighbours is out of date.
        bool const stale = (!reusable || !routes_in<S>(*frame)) && frame->view_changed != 0 &&
                           (owed_copies.first != 0 || !in_picture(here, *frame));
        // In the first pass, Project and routing have marked the slots that owe copies. An arrival waits for its turn among these slots.
        bool const in_turn = owed_copies.open != 0 || owed_copies.first != 0 || ranks_in<S>(*frame);
        bool waiting = owed_copies.open != 0 || (owed_copies.first != 0 && counts.changes != 0);
        std::uint32_t open = 0;
        detail::LookupOf<S> lookup;
        // A few at a time, so that the host's memory answers for several at once: first look for the records, then use what was found. A
        // tile has one parent in a record's tree, so no two messages of a pass bring one record. A record that took the slot of another one
        // since then came from the same side, so the bits that its message would set are set, and the other record, the one that covered
        // least, is counted.
        constexpr std::uint32_t at_once = 16;
        std::uint32_t slots[4 * at_once];
        for (Direction d : news) {
            std::uint32_t const arrived = stale ? 0 : in[d].size();
            for (std::uint32_t k = 0; k < arrived && k < at_once; ++k) Access::about_to_take(*frame, in[d][k]);
            for (std::uint32_t k = 0; k < arrived; ++k) {
                auto const& message = in[d][k];
                if (k % at_once == 0)
                    for (std::uint32_t j = k; j < arrived && j < k + at_once; ++j) {
                        if (j + at_once < arrived) Access::about_to_take(*frame, in[d][j + at_once]);
                        std::uint32_t const slot = lookup.slot_of(here, *frame, marks, splats.begin(), in[d][j]);
                        if (slot != no_slot) Access::about_to_change(marks[slot]);
                        slots[j - k] = slot;
                    }
                std::uint32_t i = slots[k % at_once];
                if (i == no_slot) {
                    auto const entry = Copies::splat(message, *frame);
                    counts.projected += reusable ? 1 : 0;
                    if (!Access::is_here(here, *frame, entry)) continue; // it was sent in an older view
                    i = storage.size();
                    bool placed = false;
                    if constexpr (may_rank<typename S::Saturation>)
                        if (ranks_in<S>(*frame) && i == storage.capacity()) {
                            i = detail::take_place<S>(here, *frame, storage, marks, splats, counts, lookup,
                                                      Copies::template record<typename S::Record>(message), entry, Mark::copy);
                            if (i == no_slot) continue;
                            placed = true;
                        }
                    if (!placed) {
                        if (!storage.try_push(Copies::template record<typename S::Record>(message))) {
                            ++counts.copies_full;
                            continue;
                        }
                        marks.unchecked_push({message.id, Mark::copy});
                        splats.unchecked_push(entry);
                        lookup.add(entry);
                        ++counts.changes;
                    }
                }
                Reach const r = Access::reach(here, *frame, splats[i]);
                marks[i].bits |= r.sides & Mark::shared(d);
                if (in_turn) {
                    marks[i].bits |= Mark::owes;
                    waiting = true;
                } else {
                    open += send_owed(i, r) ? 1 : 0;
                }
            }
        }
        if constexpr (may_rank<typename S::Saturation>)
            if (waiting && ranks_in<S>(*frame)) send_largest(here, *frame, storage, marks, splats, out);
        if (waiting) {
            for (std::uint32_t at = 0, n = storage.size(); at < n;) {
                std::uint32_t const owing = list_up_with_bits(marks.begin(), at, n, Mark::owes, slots, 4 * at_once);
                for (std::uint32_t k = 0; k < owing; ++k) Access::about_to_send(*frame, splats[slots[k]], storage[slots[k]]);
                for (std::uint32_t k = 0; k < owing; ++k)
                    open += send_owed(slots[k], Access::reach(here, *frame, splats[slots[k]])) ? 1 : 0;
            }
        }
        owed_copies = {open, 0};
        return open == 0 ? Vote::quiet : Vote::busy;
    }

    /// Sends the owed copies of the records that cover most, as far as each side has room for all copies of an octave.
    static void send_largest(Here const& here, typename S::Parameters const& frame, Storage<S> const& storage, Marks<S>& marks,
                             Splats<S> const& splats, Out<Beam<S>>& out) noexcept
    {
        auto const owed_by = [&](std::uint32_t i) noexcept {
            if (!marks[i].is(Mark::owes)) return 0u;
            Reach const r = Access::reach(here, frame, splats[i]);
            return r.sides & child_sides(r.anchor, here.tile) & ~marks[i].bits;
        };
        detail::SideCuts cuts;
        std::uint32_t const n = storage.size();
        for (std::uint32_t i = 0; i < n; ++i)
            if (std::uint32_t const owed = owed_by(i); owed != 0) {
                std::uint32_t const octave = detail::SideCuts::octave_of(Access::splat_of(frame, splats[i]));
                for (Direction d : news)
                    if ((owed & Mark::shared(d)) != 0) cuts.add(d, octave);
            }
        for (Direction d : news) cuts.close(d, out[d].room());
        for (std::uint32_t i = 0; i < n; ++i)
            if (std::uint32_t const owed = owed_by(i); owed != 0) {
                auto const& splat = Access::splat_of(frame, splats[i]);
                std::uint32_t const octave = detail::SideCuts::octave_of(splat);
                for (Direction d : news)
                    if ((owed & Mark::shared(d)) != 0 && cuts.has_room(d, octave)) {
                        out[d].unchecked_push(Copies::make(storage[i], splat));
                        marks[i].bits |= Mark::shared(d);
                    }
            }
    }

    /// For a cost model. The tile looks up each arrival among its records and projects it, and it gives each copy that leaves to a channel.
    /// Each arrival settles on this tile: a message that goes on from here is another copy.
    static Operations operations(Broadcast<typename S::Parameters> frame, Marks<S> const& marks, In<Beam<S>> in,
                                 Out<Beam<S>> out) noexcept
    {
        std::uint32_t arrived = 0, left = 0;
        for (Direction d : news) {
            arrived += in[d].size();
            left += out[d].size();
        }
        Operations o;
        o[Operation::copied] = arrived + left;
        o[Operation::projection] = projections_through(frame->view.camera, Copies::reusable_in(*frame) ? arrived : 0);
        o[Operation::slot] = times(arrived + (left > arrived ? 1 : 0), marks.size());
        o.settled_bytes = times(arrived, Access::template beam_bytes<BeamMessage<S>>(*frame));
        return o;
    }
};
} // namespace kernel

/// Sends each record along the tree of footprint.hpp to every tile that its footprint touches and that does not hold the record yet. Runs
/// until quiet.
///
/// A tile knows which neighbours hold a record: it sets `Mark::shared(d)` when it sends the record to side d or receives it from there. It
/// sends a copy only if that bit is not set. So a static view sends nothing, and a small step of the camera sends a few copies. When the
/// root of the tree moves, a tile may receive a copy that it already has; it then only notes that the sender has the record too. With
/// `Hold`, a copy that finds no free slot in a channel stays owed. With `Drop`, the tile gives the copy up and marks it. Storage is the
/// sink of copies, so bloom needs no credits and no FIFO, and it cannot deadlock.
///
/// When the mesh is quiet and no copy was refused, exactly the tiles that a record's footprint touches hold the record. Cost: one message
/// per new copy. When an anchor moves to another row, bloom sends at most as many further messages as the footprint is tiles wide.
template <class S>
using Bloom = kernel::Bloom<PoliciesOf<S>>;

}}} // namespace tilemesh::splat
