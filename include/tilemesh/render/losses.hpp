#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>
#include <tilemesh/render/detail/sorted_table.hpp>
#include <tilemesh/render/project_records.hpp>
#include <tilemesh/render/record_table.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <utility>
#include <vector>

/// Compares a mesh with what it should hold: every record once, and a copy on every tile that a record's footprint touches. The comparison
/// reads the final state of the tiles, no counters. So its list contains everything that the picture lacks.
namespace tilemesh { inline namespace v0_2 { namespace render {

/// What the tiles hold, as lists of plain words.
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
/// The lists of the tiles of this process, in the order of tiles.
template <class P, class Host>
FactLists fact_lists(Host& host)
{
    FactLists lists;
    auto& mesh = host.mesh();
    auto const& frame = mesh.template broadcast<typename P::Parameters>();
    auto const grid = mesh.grid();
    for (std::uint32_t t = 0; t < grid.size(); ++t) {
        if (!host.has(grid.tile(t))) continue;
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
            auto const add = [&](auto const& fifo) {
                for (auto const& m : fifo) lists.under_way.push_back(P::Addressing::record(m).id);
            };
            add(std::as_const(mesh).template state<splat::Waiting<P, 0>>(grid.tile(t)));
            add(std::as_const(mesh).template state<splat::Waiting<P, 1>>(grid.tile(t)));
        }
        if constexpr (P::blooms)
            for (Direction d : news)
                for (auto const& m : mesh.template incoming<splat::Beam<P>>(grid.tile(t), d))
                    lists.copies_under_way.push_back({m.id, t, 0});
    }
    return lists;
}
/// The places of all records on a mesh between two runs. Making it reads every stored record, so it is made only for frames that refused a
/// record or may have left records under way.
struct MeshFacts {
    SortedTable held;                         ///< `key` of id and tile -> the bits of the record's mark
    SortedTable owners;                       ///< `key` of an anchored record's id -> index of its splat in `splats`
    std::vector<splat::Splat> splats;
    std::vector<splat::GaussianId> under_way; ///< records in channels and FIFOs, in the order of tiles
    SortedTable copies_under_way;             ///< `key` of id and of the tile that the copy reaches next
    std::vector<std::uint32_t> parked;        ///< of each tile: its records with nothing on screen

    /// From the lists of all tiles.
    explicit MeshFacts(FactLists lists);
    static std::uint64_t key(splat::GaussianId id, std::uint32_t tile = 0) noexcept
    {
        return std::uint64_t{static_cast<std::uint32_t>(id)} << 32 | tile;
    }
};

/// What earlier frames left on a mesh. It does not follow from the view.
struct LeftBehind {
    bool copies_lost = false;    ///< copies found no storage; tiles do not send these again by themselves
    bool copies_refused = false; ///< copies met a full channel; tiles owe them again in a new view
    bool cut = false;            ///< a bound may have left records under way

    bool lacks_copies() const noexcept { return copies_lost || copies_refused; }
    /// After a frame. A loss lasts until the records are sent again: a frame that refused no record may still lack records that an earlier
    /// frame lost.
    void count(report::FrameReport const& r, bool resent, bool new_view) noexcept
    {
        copies_lost = r.refused.copies_full != 0 || (copies_lost && !resent);
        copies_refused = r.refused.copies_refused != 0 || (copies_refused && !new_view);
    }
};

/// The facts about the frame that the list of losses needs.
struct LossQuestion {
    Grid grid;
    splat::View view;
    splat::Tiling tiling;
    bool routes, blooms, holds;
    bool bounded; ///< the frame's hops were bounded: records may be under way, and copies of lost records stay on their tiles
    std::uint32_t slots; ///< of a tile's storage
};

/// The rows of a map in a view: what the list of losses reads of them. It reads them in a table, or in a list of all rows.
class ScreenRows {
public:
    struct Row {
        splat::GaussianId id;
        splat::Splat splat;
    };
    explicit ScreenRows(RecordTable const& records) : records_(&records) {}
    explicit ScreenRows(std::vector<Row> rows) : rows_(std::move(rows)) {}
    std::uint32_t rows() const noexcept { return records_ != nullptr ? records_->rows() : static_cast<std::uint32_t>(rows_.size()); }
    splat::GaussianId id(std::uint32_t row) const noexcept { return records_ != nullptr ? records_->id(row) : rows_[row].id; }
    splat::Splat project(std::uint32_t row, splat::View const& view, splat::Tiling const& tiling) const noexcept
    {
        return records_ != nullptr ? project_row(*records_, row, view, tiling) : rows_[row].splat;
    }

private:
    RecordTable const* records_ = nullptr;
    std::vector<Row> rows_;
};

/// Rows of records that no tile owns when a frame ends.
struct NotOnTiles {
    std::vector<std::uint32_t> missing;   ///< nowhere on the mesh, in order
    std::vector<splat::GaussianId> missing_ids; ///< of these rows
    std::vector<std::uint32_t> under_way; ///< in channels and FIFOs, in the order of tiles
};

/// Lists what the picture lacks: fills `lost` in the report, and the counts that follow from it. Returns the rows that no tile owns. Cost:
/// one or two projections per record of the map.
TILEMESH_HOST NotOnTiles list_losses(LossQuestion const& question, ScreenRows const& records, MeshFacts const& facts, report::FrameReport& r);

}}} // namespace tilemesh::render

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/render/detail/losses_code.hpp>
#endif
