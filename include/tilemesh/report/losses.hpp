#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/splat/referenced.hpp>
#include <unordered_map>
#include <utility>
#include <vector>

namespace tilemesh::report {

/// Compares what is on a mesh with what should be: every record once, and a copy on every tile that its footprint touches.
/// Knows nothing of what happened: it reads facts, so what it lists is all that the picture lacks, whatever was counted.
///
/// `S` is a setup; `Machine` a Mesh or CheckedMesh between runs. Costs a look at every stored record: only for frames in which
/// something was refused or may be under way.
template <class S, class Machine>
class LossFinder {
public:
    using Record = typename splat::ValueOf<S>::type::Record;

    /// `bounded`: the frame's hops are, so that records may be under way and copies of lost records stay on their tiles.
    LossFinder(Machine& mesh, std::span<Record const> gaussians, bool bounded)
        : mesh_(mesh), frame_(mesh.template broadcast<typename S::Parameters>()), gaussians_(gaussians), bounded_(bounded)
    {
        auto const grid = mesh_.grid();
        for (std::uint32_t t = 0; t < grid.size(); ++t) {
            auto const marks = std::as_const(mesh_).template state<splat::Marks<S>>(grid.tile(t));
            auto const splats = std::as_const(mesh_).template state<splat::Splats<S>>(grid.tile(t));
            for (std::uint32_t i = 0; i < marks.size(); ++i) {
                held_.emplace(key(marks[i].id, t), marks[i].bits);
                if (!marks[i].is(splat::Mark::copy)) owners_.emplace(marks[i].id, look(frame_, splats[i]));
            }
            if constexpr (S::routes)
                for (Direction d : news)
                    for (auto const& m : mesh_.template incoming<splat::Road<S>>(grid.tile(t), d))
                        under_way_.push_back(value(S::Addressing::record(m)));
            if constexpr (S::routes && S::Saturation::holds) {
                for (auto const& m : std::as_const(mesh_).template state<splat::Waiting<S, 0>>(grid.tile(t)))
                    under_way_.push_back(value(S::Addressing::record(m)));
                for (auto const& m : std::as_const(mesh_).template state<splat::Waiting<S, 1>>(grid.tile(t)))
                    under_way_.push_back(value(S::Addressing::record(m)));
            }
        }
    }

    /// Fills `lost` and its sums in the report. Returns the rows of `gaussians` that are nowhere on the mesh, in order.
    std::vector<std::uint32_t> list(FrameReport& r)
    {
        std::unordered_map<splat::GaussianId, bool> moving;
        r.gaussians.under_way = under_way_.size();
        for (auto const& g : under_way_) {
            moving.emplace(g.id, true);
            list_without_owner(r, g, Cause::late);
        }
        std::vector<std::uint32_t> gone;
        for (std::uint32_t row = 0; row < gaussians_.size(); ++row) {
            auto const& g = gaussians_[row];
            if (owners_.count(g.id) != 0 || moving.count(g.id) != 0) continue;
            // Where the host places the records it keeps those with nothing on screen.
            if (!S::routes && !splat::project(g, frame_.view, frame_.tiling).visible()) continue;
            gone.push_back(row);
            if (S::Saturation::holds && !bounded_)
                r.lost.push_back({g.id, Loss::whole, Cause::unplaced}); // the host recalls its copies
            else
                list_without_owner(r, g, S::Saturation::holds ? Cause::unplaced : Cause::storage_full);
        }
        (S::Saturation::holds ? r.gaussians.unplaced : r.gaussians.dropped) = gone.size();
        for (auto const& g : gaussians_) {
            auto const owner = owners_.find(g.id);
            if (owner != owners_.end()) list_missing_copies(r, g.id, owner->second);
        }
        return gone;
    }

private:
    static Record const& value(Record const& g) noexcept { return g; }
    Record const& value(splat::Reference<Record> const& g) const noexcept { return gaussians_[g.row]; }
    static std::uint64_t key(splat::GaussianId id, std::uint32_t tile) noexcept
    {
        return std::uint64_t{static_cast<std::uint32_t>(id)} << 32 | tile;
    }
    /// Calls f(tile) for each tile that the splat touches.
    template <class F>
    void for_each_tile(splat::Splat const& s, F const& f) const
    {
        if (!s.visible()) return;
        auto const range = splat::tiles_of(s, frame_.tiling);
        for (auto y = range.first.y(); y <= range.last.y(); ++y)
            for (auto x = range.first.x(); x <= range.last.x(); ++x) f(TileId::at(x, y));
    }
    /// A record that no tile owns but that may have left copies: the tiles that lack one, or the record where all do.
    void list_without_owner(FrameReport& r, Record const& g, Cause cause)
    {
        auto const s = splat::project(g, frame_.view, frame_.tiling);
        if (!s.visible() && cause == Cause::late) return; // nothing to be late for
        std::vector<std::uint32_t> lacking;
        bool any = false;
        for_each_tile(s, [&](TileId t) {
            auto const index = mesh_.grid().index_of(t);
            if (held_.count(key(g.id, index)) != 0)
                any = true;
            else
                lacking.push_back(index);
        });
        if (!any) lacking.assign(1, Loss::whole);
        for (auto t : lacking) r.lost.push_back({g.id, t, cause});
    }
    void list_missing_copies(FrameReport& r, splat::GaussianId id, splat::Splat const& s)
    {
        for_each_tile(s, [&](TileId t) {
            auto const index = mesh_.grid().index_of(t);
            if (held_.count(key(id, index)) != 0) return;
            auto const cause = why_missing(id, s.anchor, t);
            ++(cause == Cause::late ? r.late_copies : r.lost_copies);
            r.lost.push_back({id, index, cause});
        });
    }
    /// Up the tree from a tile without the copy to the first that has it: what stopped it there stopped all behind.
    Cause why_missing(splat::GaussianId id, TileId anchor, TileId t)
    {
        auto const grid = mesh_.grid();
        Direction towards_child = Direction::north;
        auto holder = held_.end();
        for (TileId at = t; !(at == anchor) && holder == held_.end();) {
            Direction const up = at.y() != anchor.y() ? (at.y() > anchor.y() ? Direction::north : Direction::south)
                                                      : (at.x() > anchor.x() ? Direction::west : Direction::east);
            towards_child = opposite(up);
            t = at;
            at = grid.neighbour(at, up);
            holder = held_.find(key(id, grid.index_of(at)));
        }
        if (holder == held_.end()) return Cause::late; // the record itself has not arrived
        if constexpr (!S::blooms) return Cause::no_bloom;
        if ((holder->second & splat::Mark::refused(towards_child)) != 0) return Cause::channel_full;
        if ((holder->second & splat::Mark::shared(towards_child)) != 0 && !in_beam(id, t)) return Cause::storage_full;
        return Cause::late;
    }
    bool in_beam(splat::GaussianId id, TileId t)
    {
        if constexpr (S::blooms)
            for (Direction d : news)
                for (auto const& m : mesh_.template incoming<splat::Beam<S>>(t, d))
                    if (m.id == id) return true;
        return false;
    }

    Machine& mesh_;
    typename S::Parameters frame_;
    std::span<Record const> gaussians_;
    bool bounded_;
    std::unordered_map<std::uint64_t, std::uint32_t> held_; ///< (id, tile) -> the bits of its mark
    std::unordered_map<splat::GaussianId, splat::Splat> owners_;
    std::vector<Record> under_way_;
};

} // namespace tilemesh::report
