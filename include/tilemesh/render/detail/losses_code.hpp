#pragma once
#include <cstdint>
#include <optional>
#include <tilemesh/render/detail/sorted_table.hpp>
#include <tilemesh/render/losses.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

TILEMESH_HOST MeshFacts::MeshFacts(FactLists lists) : under_way(std::move(lists.under_way)), parked(std::move(lists.parked))
{
    for (auto const& h : lists.held) held.add(key(h.id, h.tile), h.bits);
    for (auto const& o : lists.owned) {
        owners.add(key(o.id), static_cast<std::uint32_t>(splats.size()));
        splats.push_back(o.splat);
    }
    for (auto const& c : lists.copies_under_way) copies_under_way.add(key(c.id, c.tile), 0);
    for (auto* const table : {&held, &owners, &copies_under_way}) (void)table->sort();
}

namespace detail {
/// Lists what the picture lacks.
class LossFinder {
public:
    LossFinder(LossQuestion const& question, ScreenRows const& records, MeshFacts const& facts)
        : ask_(question), records_(records), facts_(facts)
    {
    }

    NotOnTiles list(report::FrameReport& r)
    {
        NotOnTiles off;
        r.gaussians.under_way = facts_.under_way.size();
        SortedTable row_of, moving;
        if (!facts_.under_way.empty())
            for (std::uint32_t row = 0; row < records_.rows(); ++row) row_of.add(MeshFacts::key(records_.id(row)), row);
        for (auto const id : facts_.under_way) moving.add(MeshFacts::key(id), 0);
        (void)row_of.sort();
        (void)moving.sort();
        for (auto const id : facts_.under_way) {
            off.under_way.push_back(*row_of.find(MeshFacts::key(id)));
            list_without_owner(r, off.under_way.back(), report::Cause::late);
        }
        for (std::uint32_t row = 0; row < records_.rows(); ++row) {
            auto const id = records_.id(row);
            if (facts_.owners.has(MeshFacts::key(id)) || moving.has(MeshFacts::key(id))) continue;
            // A host that places the records keeps the records with nothing on screen.
            if (!ask_.routes && !project(row).visible()) continue;
            off.missing.push_back(row);
            off.missing_ids.push_back(id);
            if (ask_.holds && !ask_.bounded) // the host recalls its copies
                r.lost.push_back({id, report::Loss::whole, report::Cause::unplaced, anchor_of(project(row))});
            else
                list_without_owner(r, row, ask_.holds ? report::Cause::unplaced : report::Cause::storage_full);
        }
        (ask_.holds ? r.gaussians.unplaced : r.gaussians.dropped) = off.missing.size();
        for (std::uint32_t row = 0; row < records_.rows(); ++row) {
            auto const* const owner = facts_.owners.find(MeshFacts::key(records_.id(row)));
            if (owner != nullptr) list_missing_copies(r, records_.id(row), facts_.splats[*owner]);
        }
        if (r.losses(report::Cause::unplaced) + r.losses(report::Cause::storage_full) != 0) r.full_tiles = full_tiles();
        return off;
    }

private:
    /// The tiles that need more slots than they have. Cost: one projection per record of the map.
    std::optional<report::FullTiles> full_tiles() const
    {
        auto needed = facts_.parked;
        for (std::uint32_t row = 0; row < records_.rows(); ++row) {
            auto const s = project(row);
            if (ask_.blooms) for_each_tile(s, [&](TileId t) { ++needed[ask_.grid.index_of(t)]; });
            else if (s.visible()) ++needed[ask_.grid.index_of(s.anchor)];
        }
        report::FullTiles full{0, 0, 0, ask_.slots};
        for (std::uint32_t t = 0; t < needed.size(); ++t) {
            full.count += needed[t] > ask_.slots ? 1u : 0u;
            if (needed[t] > full.slots_needed) full.fullest = t, full.slots_needed = needed[t];
        }
        if (full.count == 0) return {};
        return full;
    }
    /// The tile that has no slot for a record; `whole` if the record has nothing on screen.
    std::uint32_t anchor_of(splat::Splat const& s) const { return s.visible() ? ask_.grid.index_of(s.anchor) : report::Loss::whole; }
    splat::Splat project(std::uint32_t row) const { return records_.project(row, ask_.view, ask_.tiling); }
    bool holds_a_copy(splat::GaussianId id, std::uint32_t tile) const { return facts_.held.has(MeshFacts::key(id, tile)); }
    /// Calls f(tile) for each tile that the splat touches.
    template <class F>
    void for_each_tile(splat::Splat const& s, F const& f) const
    {
        if (!s.visible()) return;
        auto const range = splat::tiles_of(s, ask_.tiling);
        for (auto y = range.first.y(); y <= range.last.y(); ++y)
            for (auto x = range.first.x(); x <= range.last.x(); ++x) f(TileId::at(x, y));
    }
    /// Lists a record that no tile owns. If it left copies, it lists the tiles that lack one (the anchor tile may be among them). Otherwise
    /// it lists the whole record.
    void list_without_owner(report::FrameReport& r, std::uint32_t row, report::Cause cause)
    {
        auto const s = project(row);
        auto const id = records_.id(row);
        if (!s.visible() && cause == report::Cause::late) return; // a record with nothing on screen is not late
        std::vector<std::uint32_t> lacking;
        bool any = false;
        for_each_tile(s, [&](TileId t) {
            auto const index = ask_.grid.index_of(t);
            if (holds_a_copy(id, index))
                any = true;
            else
                lacking.push_back(index);
        });
        if (!any) r.lost.push_back({id, report::Loss::whole, cause, cause == report::Cause::unplaced ? anchor_of(s) : report::Loss::whole});
        if (any)
            for (auto t : lacking) list_copy(r, {id, t, cause});
    }
    static void list_copy(report::FrameReport& r, report::Loss const& copy)
    {
        ++(copy.cause == report::Cause::late ? r.late_copies : r.lost_copies);
        r.lost.push_back(copy);
    }
    void list_missing_copies(report::FrameReport& r, splat::GaussianId id, splat::Splat const& s)
    {
        for_each_tile(s, [&](TileId t) {
            auto const index = ask_.grid.index_of(t);
            if (!holds_a_copy(id, index)) list_copy(r, {id, index, why_missing(id, s.anchor, t)});
        });
    }
    /// Goes up the tree from a tile without the copy to the first tile that has it. The cause that stopped the copy there is the cause for
    /// all tiles below it.
    report::Cause why_missing(splat::GaussianId id, TileId anchor, TileId t) const
    {
        Direction towards_child = Direction::north;
        std::uint32_t const* holder = nullptr; // its mark's bits
        for (TileId at = t; !(at == anchor) && holder == nullptr;) {
            Direction const up = at.y() != anchor.y() ? (at.y() > anchor.y() ? Direction::north : Direction::south)
                                                      : (at.x() > anchor.x() ? Direction::west : Direction::east);
            towards_child = opposite(up);
            t = at;
            at = ask_.grid.neighbour(at, up);
            holder = facts_.held.find(MeshFacts::key(id, ask_.grid.index_of(at)));
        }
        if (holder == nullptr) return report::Cause::late; // the record itself has not arrived
        if (!ask_.blooms) return report::Cause::no_bloom;
        if ((*holder & splat::Mark::refused(towards_child)) != 0) return report::Cause::channel_full;
        bool const arriving = facts_.copies_under_way.has(MeshFacts::key(id, ask_.grid.index_of(t)));
        if ((*holder & splat::Mark::shared(towards_child)) != 0 && !arriving) return report::Cause::storage_full;
        return report::Cause::late;
    }

    LossQuestion ask_;
    ScreenRows const& records_;
    MeshFacts const& facts_;
};
} // namespace detail

TILEMESH_HOST NotOnTiles list_losses(LossQuestion const& question, ScreenRows const& records, MeshFacts const& facts, report::FrameReport& r)
{
    return detail::LossFinder(question, records, facts).list(r);
}

}}} // namespace tilemesh::render
