#pragma once
#include <tilemesh/splat/policies.hpp>

namespace tilemesh::splat {

namespace detail {
/// What Project does with a tile's records; returns how many wait to leave.
template <class S>
std::uint32_t begin_frame(Here const& here, FrameParameters const& frame, Storage<S>& storage, Marks<S>& marks, Splats<S>& splats,
                          Counts& counts) noexcept
{
    counts = {};
    std::uint32_t leaving = 0;
    bool const forget = frame.anew != 0 || (!S::Copies::reusable && frame.view_changed != 0);
    for (std::uint32_t i = storage.size(); i-- > 0;) {
        bool const copy = S::blooms && marks[i].is(Mark::copy);
        if (copy && !S::Copies::reusable) { // its splat is all there is of it, and it is good for one view
            if (forget) remove_slot(storage, marks, splats, i);
            continue;
        }
        auto const s = project(storage[i], frame.view, frame.tiling);
        ++counts.projected;
        if (copy && !covers(s, frame.tiling, here.tile)) {
            remove_slot(storage, marks, splats, i);
            continue;
        }
        splats[i] = s;
        [[maybe_unused]] std::uint32_t bits = marks[i].bits;
        if constexpr (S::blooms)
            for (Direction d : news)
                if (forget || (frame.view_changed != 0 && (bits & Mark::refused(d)) != 0) ||
                    !here.grid.has_neighbour(here.tile, d) ||
                    !covers(s, frame.tiling, here.grid.neighbour(here.tile, d)))
                    bits &= ~(Mark::shared(d) | Mark::refused(d));
        if (!copy) {
            if constexpr (S::routes) {
                bool const goes = s.visible() && !(s.anchor == here.tile);
                if (goes && (bits & Mark::leaving) == 0) ++counts.moved;
                bits = goes ? bits | Mark::leaving : bits & ~Mark::leaving;
                leaving += goes ? 1 : 0;
            }
            ++(s.visible() ? counts.visible : counts.parked);
        }
        if constexpr (S::routes || S::blooms) marks[i].bits = bits;
    }
    return leaving;
}
inline Vote vote_to_route(Traffic& traffic, std::uint32_t leaving) noexcept
{
    traffic.leaving = leaving;
    return leaving + traffic.waiting + traffic.sent[0] + traffic.sent[1] != 0 ? Vote::busy : Vote::quiet;
}
} // namespace detail

/// Begins a frame on a tile: projects all it holds in the new view, marks the anchored records that must leave, and drops the
/// copies whose footprint left the tile. Votes busy where a record must leave or waits.
///
/// After this, on every tile: a copy is here only if its footprint touches the tile; `Mark::shared(d)` is set only if the
/// neighbour on side d holds the record; what a full channel refused is owed again in a new view. Both tiles of a pair decide
/// with the same words and the same view, so no message is needed for a copy to end. Cost: one projection a stored record; no exchange. A setup that does not route or bloom keeps
/// nothing for it.
template <class S, bool Routes = S::routes, bool Blooms = S::blooms>
struct Project;

template <class S>
struct Project<S, true, true> {
    static constexpr char const* name = "project";
    Vote operator()(Here here, Broadcast<FrameParameters> frame, Storage<S>& storage, Marks<S>& marks, Splats<S>& splats,
                    Traffic& traffic, Debts& debts, Counts& counts) const noexcept
    {
        debts = {1, 1};
        return detail::vote_to_route(traffic, detail::begin_frame<S>(here, *frame, storage, marks, splats, counts));
    }
};
template <class S>
struct Project<S, true, false> {
    static constexpr char const* name = "project";
    Vote operator()(Here here, Broadcast<FrameParameters> frame, Storage<S>& storage, Marks<S>& marks, Splats<S>& splats,
                    Traffic& traffic, Counts& counts) const noexcept
    {
        return detail::vote_to_route(traffic, detail::begin_frame<S>(here, *frame, storage, marks, splats, counts));
    }
};
template <class S>
struct Project<S, false, true> {
    static constexpr char const* name = "project";
    void operator()(Here here, Broadcast<FrameParameters> frame, Storage<S>& storage, Marks<S>& marks, Splats<S>& splats,
                    Debts& debts, Counts& counts) const noexcept
    {
        debts = {1, 1};
        (void)detail::begin_frame<S>(here, *frame, storage, marks, splats, counts);
    }
};
template <class S>
struct Project<S, false, false> {
    static constexpr char const* name = "project";
    void operator()(Here here, Broadcast<FrameParameters> frame, Storage<S>& storage, Marks<S>& marks, Splats<S>& splats,
                    Counts& counts) const noexcept
    {
        (void)detail::begin_frame<S>(here, *frame, storage, marks, splats, counts);
    }
};

} // namespace tilemesh::splat
