#pragma once
#include <tilemesh/splat/policies.hpp>

namespace tilemesh::splat {

/// Begins a frame on a tile: projects all it holds in the new view, marks the anchored records that must leave, and drops the
/// copies whose footprint left the tile. Votes busy where a record must leave or waits.
///
/// After this, on every tile: a copy is here only if its footprint touches the tile; `Mark::shared(d)` is set only if the
/// neighbour on side d holds the record. Both tiles of a pair decide with the same words and the same view, so no message is
/// needed for a copy to end. Cost: one projection a stored record; no exchange.
template <class S>
struct Project {
    static constexpr char const* name = "project";

    Vote operator()(Here here, Broadcast<FrameParameters> frame, Storage<S>& storage, Marks<S>& marks, Splats<S>& splats,
                    Traffic& traffic, Debts& debts, Counts& counts) const noexcept
    {
        counts = {};
        traffic.leaving = 0;
        bool const forget = frame->anew != 0 || (!S::Copies::reusable && frame->view_changed != 0);
        for (std::uint32_t i = storage.size(); i-- > 0;) {
            bool const copy = marks[i].is(Mark::copy);
            if (copy && !S::Copies::reusable) { // its splat is all there is of it, and it is good for one view
                if (forget) remove_slot(storage, marks, splats, i);
                continue;
            }
            auto const s = project(storage[i], frame->view, frame->tiling);
            ++counts.projected;
            if (copy && !covers(s, frame->tiling, here.tile)) {
                remove_slot(storage, marks, splats, i);
                continue;
            }
            splats[i] = s;
            std::uint32_t bits = marks[i].bits;
            for (Direction d : news)
                if (forget || !here.grid.has_neighbour(here.tile, d) ||
                    !covers(s, frame->tiling, here.grid.neighbour(here.tile, d)))
                    bits &= ~(Mark::shared(d) | Mark::refused(d));
            if (!copy) {
                bool const goes = s.visible() && !(s.anchor == here.tile);
                if (goes && (bits & Mark::leaving) == 0) ++counts.moved;
                bits = goes ? bits | Mark::leaving : bits & ~Mark::leaving;
                traffic.leaving += goes ? 1 : 0;
                ++(s.visible() ? counts.visible : counts.parked);
            }
            marks[i].bits = bits;
        }
        debts = {1, 1};
        return traffic.leaving + traffic.waiting + traffic.sent[0] + traffic.sent[1] != 0 ? Vote::busy : Vote::quiet;
    }
};

} // namespace tilemesh::splat
