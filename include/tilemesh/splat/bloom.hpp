#pragma once
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
        // Sends slot i where it is owed; true when something remains owed.
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

        // What was under way when the view changed: a projected copy shows the old view, and its sender has forgotten it; where the
        // host places the records, nobody is what its sender thought it was.
        bool const stale = (!reusable || !S::routes) && frame->view_changed != 0 &&
                           (owed_copies.first != 0 || !in_picture(here, *frame));
        // In the first superstep Project and routing have said who owes, and what arrives waits for its turn among them.
        bool const in_turn = owed_copies.open != 0 || owed_copies.first != 0;
        bool waiting = owed_copies.open != 0 || (owed_copies.first != 0 && counts.changes != 0);
        std::uint32_t open = 0;
        for (Direction d : news)
            for (auto const& message : in[d]) {
                if (stale) break;
                auto i = Access::slot_of(marks, splats.begin(), message);
                if (i == no_slot) {
                    auto const entry = Copies::splat(message, *frame);
                    counts.projected += reusable ? 1 : 0;
                    if (!Access::is_here(here, *frame, entry)) continue; // under way since an older view
                    i = storage.size();
                    if (!storage.try_push(Copies::template record<typename S::Record>(message))) {
                        ++counts.copies_full;
                        continue;
                    }
                    marks.unchecked_push({message.id, Mark::copy});
                    splats.unchecked_push(entry);
                    ++counts.changes;
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
        if (waiting)
            for (std::uint32_t i = 0, n = storage.size(); i < n; ++i)
                if (marks[i].is(Mark::owes)) open += send_owed(i, Access::reach(here, *frame, splats[i])) ? 1 : 0;
        owed_copies = {open, 0};
        return open == 0 ? Vote::quiet : Vote::busy;
    }

    /// For a cost model: an arrival is looked for among the tile's records and projected, a copy given to a channel. Each
    /// arrival settles: what goes on from here is another copy.
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
        o[Operation::projection] = Copies::reusable_in(*frame) ? arrived : 0;
        o[Operation::slot] = times(arrived + (left > arrived ? 1 : 0), marks.size());
        o.settled_bytes = times(arrived, Access::template beam_bytes<BeamMessage<S>>(*frame));
        return o;
    }
};
} // namespace kernel

/// Sends each record along the tree of footprint.hpp to every tile that its footprint touches and that does not hold it yet. Runs until
/// quiet.
///
/// A tile knows which neighbours hold a record: it sets `Mark::shared(d)` when it sends the record to side d or gets it from there. It
/// sends a copy only if that bit is not set, so a static view sends nothing and a small step sends a few copies. When the root of the
/// tree moves, a tile may get a copy that it has; it then only notes that the sender has it too. With `Hold`, a copy that finds no slot
/// in a channel stays owed; with `Drop`, the tile gives it up and marks it. Storage is the sink of copies: bloom needs no credits and no
/// FIFO, and cannot dead-lock.
///
/// When the mesh is quiet and nothing was refused, exactly the tiles that a record's footprint touches hold it. Cost: one message per
/// new copy, plus at most the width of the footprint in tiles when an anchor changes row.
template <class S>
using Bloom = kernel::Bloom<PoliciesOf<S>>;

}}} // namespace tilemesh::splat
