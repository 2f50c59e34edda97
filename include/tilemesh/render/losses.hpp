#pragma once
#include <cstdint>
#include <optional>
#include <tilemesh/render/over_ranks.hpp>
#include <tilemesh/render/record_table.hpp>
#include <tilemesh/render/setup_facts.hpp>
#include <tilemesh/render/sorted_table.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <utility>
#include <vector>

/// Compares a mesh with what it should hold: every record once, and a copy on every tile that a record's footprint touches. The comparison
/// reads the final state of the tiles, no counters. So its list contains everything that the picture lacks.
namespace tilemesh { inline namespace v0_2 { namespace render {

/// The places of all records on a mesh between two runs. Making it reads every stored record, so it is made only for frames that refused a
/// record or may have left records under way.
struct MeshFacts {
    SortedTable held;                         ///< `key` of id and tile -> the bits of the record's mark
    SortedTable owners;                       ///< `key` of an anchored record's id -> index of its splat in `splats`
    std::vector<splat::Splat> splats;
    std::vector<splat::GaussianId> under_way; ///< records in channels and FIFOs, in the order of tiles
    SortedTable copies_under_way;             ///< `key` of id and of the tile that the copy reaches next
    std::vector<std::uint32_t> parked;        ///< of each tile: its records with nothing on screen

    static std::uint64_t key(splat::GaussianId id, std::uint32_t tile = 0) noexcept
    {
        return std::uint64_t{static_cast<std::uint32_t>(id)} << 32 | tile;
    }
};
/// The facts as lists of plain words, which processes can send.
struct FactLists {
    struct Held {
        splat::GaussianId id;
        std::uint32_t tile, bits;
    };
    struct Owned {
        splat::GaussianId id;
        splat::Splat splat;
    };
    std::vector<Held> held;
    std::vector<Owned> owned;
    std::vector<splat::GaussianId> under_way;
    std::vector<Held> copies_under_way;
    std::vector<std::uint32_t> parked;
};
/// The lists of the tiles of this process.
template <class P, class M>
FactLists fact_lists(M& mesh)
{
    FactLists lists;
    auto const& frame = mesh.template broadcast<typename P::Parameters>();
    auto const grid = mesh.grid();
    for (std::uint32_t t = 0; t < grid.size(); ++t) {
        if (!owns(mesh, grid.tile(t))) continue;
        auto const marks = std::as_const(mesh).template state<splat::Marks<P>>(grid.tile(t));
        auto const splats = std::as_const(mesh).template state<splat::Splats<P>>(grid.tile(t));
        std::uint32_t parked = 0;
        for (std::uint32_t i = 0; i < marks.size(); ++i) {
            lists.held.push_back({marks[i].id, t, marks[i].bits});
            if (marks[i].is(splat::Mark::copy)) continue;
            lists.owned.push_back({marks[i].id, splat::AccessOf<P>::splat_of(frame, splats[i])});
            parked += lists.owned.back().splat.visible() ? 0u : 1u;
        }
        lists.parked.push_back(parked);
        if constexpr (P::routes)
            for (Direction d : news)
                for (auto const& m : mesh.template incoming<splat::Road<P>>(grid.tile(t), d))
                    lists.under_way.push_back(P::Addressing::record(m).id);
        if constexpr (P::routes && P::Saturation::may_hold) {
            for (auto const& m : std::as_const(mesh).template state<splat::Waiting<P, 0>>(grid.tile(t)))
                lists.under_way.push_back(P::Addressing::record(m).id);
            for (auto const& m : std::as_const(mesh).template state<splat::Waiting<P, 1>>(grid.tile(t)))
                lists.under_way.push_back(P::Addressing::record(m).id);
        }
        if constexpr (P::blooms)
            for (Direction d : news)
                for (auto const& m : mesh.template incoming<splat::Beam<P>>(grid.tile(t), d))
                    lists.copies_under_way.push_back({m.id, t, 0});
    }
    return lists;
}
/// The facts of all tiles. If several processes have them, the first gets the facts, and the others get none.
template <class P, class M>
MeshFacts facts_on(M& mesh)
{
    FactLists lists;
    together(mesh, [&] { lists = fact_lists<P>(mesh); });
    join(mesh, lists.held);
    join(mesh, lists.owned);
    join(mesh, lists.under_way);
    join(mesh, lists.copies_under_way);
    join(mesh, lists.parked);
    MeshFacts facts;
    together(mesh, [&] {
        facts.under_way = std::move(lists.under_way);
        facts.parked = std::move(lists.parked);
        for (auto const& h : lists.held) facts.held.add(MeshFacts::key(h.id, h.tile), h.bits);
        for (auto const& o : lists.owned) {
            facts.owners.add(MeshFacts::key(o.id), static_cast<std::uint32_t>(facts.splats.size()));
            facts.splats.push_back(o.splat);
        }
        for (auto const& c : lists.copies_under_way) facts.copies_under_way.add(MeshFacts::key(c.id, c.tile), 0);
        for (auto* const table : {&facts.held, &facts.owners, &facts.copies_under_way}) (void)table->sort();
    });
    return facts;
}

/// The facts about the frame that the list of losses needs.
struct LossQuestion {
    Grid grid;
    splat::View view;
    splat::Tiling tiling;
    bool routes, blooms, holds;
    bool bounded; ///< the frame's hops were bounded: records may be under way, and copies of lost records stay on their tiles
    std::uint32_t slots; ///< of a tile's storage
};

/// The rows of a map in a view: what the list of losses reads of them. One process reads its table. Of several, the first collects the ids
/// and the splats of all rows.
class ScreenRows {
public:
    struct Row {
        splat::GaussianId id;
        splat::Splat splat;
    };
    /// Every process calls it. The others than the first have no rows then. Cost over several processes: 48 bytes a row in the first one.
    template <class M>
    ScreenRows([[maybe_unused]] M& mesh, [[maybe_unused]] LossQuestion const& ask, RecordTable const& records) : records_(&records)
    {
        if constexpr (over_ranks<M>) {
            together(mesh, [&] {
                for (std::uint32_t row = 0; row < records.rows(); ++row)
                    rows_.push_back({records.id(row), records.project(row, ask.view, ask.tiling)});
            });
            join(mesh, rows_);
            records_ = nullptr;
        }
    }
    std::uint32_t rows() const noexcept { return records_ != nullptr ? records_->rows() : static_cast<std::uint32_t>(rows_.size()); }
    splat::GaussianId id(std::uint32_t row) const noexcept { return records_ != nullptr ? records_->id(row) : rows_[row].id; }
    splat::Splat project(std::uint32_t row, splat::View const& view, splat::Tiling const& tiling) const noexcept
    {
        return records_ != nullptr ? records_->project(row, view, tiling) : rows_[row].splat;
    }

private:
    RecordTable const* records_;
    std::vector<Row> rows_;
};

/// Rows of records that no tile owns when a frame ends.
struct NotOnTiles {
    std::vector<std::uint32_t> missing;   ///< nowhere on the mesh, in order
    std::vector<splat::GaussianId> missing_ids; ///< of these rows; only over several processes
    std::vector<std::uint32_t> under_way; ///< in channels and FIFOs, in the order of tiles
};

/// Gives every process the losses in the first one's report, and the counts that follow from them.
template <class M>
void share_losses(M& mesh, report::FrameReport& r, NotOnTiles& off)
{
    if constexpr (over_ranks<M>) {
        share(mesh, r.lost);
        share(mesh, off.missing);
        share(mesh, off.missing_ids);
        share(mesh, off.under_way);
        auto const full = r.full_tiles.value_or(report::FullTiles{});
        std::vector<std::uint64_t> words;
        together(mesh, [&] {
            words = {r.gaussians.under_way, r.gaussians.unplaced, r.gaussians.dropped, r.lost_copies, r.late_copies, r.full_tiles ? 1u : 0u,
                     full.count, full.fullest, full.slots_needed, full.slots_available};
        });
        share(mesh, words);
        r.gaussians.under_way = words[0];
        r.gaussians.unplaced = words[1];
        r.gaussians.dropped = words[2];
        r.lost_copies = words[3];
        r.late_copies = words[4];
        if (words[5] != 0)
            r.full_tiles = {static_cast<std::uint32_t>(words[6]), static_cast<std::uint32_t>(words[7]), words[8], words[9]};
    }
}

/// Lists what the picture lacks.
class LossFinder {
public:
    LossFinder(LossQuestion const& question, ScreenRows const& records, MeshFacts const& facts)
        : ask_(question), records_(records), facts_(facts)
    {
    }

    /// Fills `lost` in the report, and the counts that follow from it.
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

}}} // namespace tilemesh::render
