#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/render/accounting.hpp>
#include <tilemesh/render/detail/sorted_table.hpp>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/render/host_form.hpp>
#include <tilemesh/render/project_records.hpp>
#include <tilemesh/render/record_table.hpp>
#include <tilemesh/render/screen_cache.hpp>
#include <tilemesh/splat/access.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// Puts a map's records onto a mesh, and knows which records are not on it. Records stay on their tiles from frame to frame; this is the
/// host's part of that protocol.
///
/// Call `begin` on an empty mesh; with routing it loads all records. With routing, call `load` in each new view for the records that a frame
/// handed back. Without routing, call `place` in each new view. After a frame, call `set_missing` and `set_under_way` with the rows that
/// the list of losses found, then `recall_copies`. Every row is on the mesh once, or in `missing()`, or (without routing) parked.
///
/// `P` is a set of policies. Member functions take the host of a mesh (render/host.hpp) that is between two runs. `Records`: a table of all
/// rows, or of the share of one of several processes. Each of these has a keeper, calls the same functions, puts records on its own tiles,
/// and has the same lists of rows: the rule that gives a row its tile is the same for all numbers of processes.
template <class P, class Records = RecordTable>
class RecordKeeper {
public:
    static constexpr bool by_reference = std::is_same_v<typename P::Record, splat::Reference>;

    /// `cache`: the host's table, if tiles hold references to it.
    RecordKeeper(Records const& records, ScreenCache* cache) : records_(records), cache_(cache) {}

    /// The rows that should be on the mesh but are not, in order.
    std::vector<std::uint32_t> const& missing() const noexcept { return missing_; }
    /// `ids`: the ids of these rows; needed if the table lacks some of them.
    void set_missing(std::vector<std::uint32_t> rows, std::vector<splat::GaussianId> ids = {})
    {
        missing_ = std::move(rows);
        missing_ids_ = std::move(ids);
    }
    /// Takes the rows that are in channels and FIFOs. No tile counts them.
    void set_under_way(std::vector<std::uint32_t> rows) { under_way_ = std::move(rows); }
    /// The number of rows that stay with the host because they have nothing on screen; only without routing. Of this process.
    std::uint64_t parked() const noexcept { return parked_; }
    /// The sums of all tiles' counters in a frame that ran, with the visible and the parked rows that no tile counts: those that the host keeps,
    /// and those under way. `host_keeps`: the host keeps the missing rows and counts them as visible until they are placed; otherwise they are
    /// lost. Call it with the frame's view, after `load` or `place` and before the `set_` functions. Cost: one projection per row under way.
    template <class Host>
    AnchoredSums sums(Host& host, splat::View const& view, splat::Tiling const& tiling, bool host_keeps) const
    {
        return host.template total<AnchoredSums>([&](AnchoredSums& all) {
            auto const& mesh = std::as_const(host.mesh());
            for_each_tile(host, [&](TileId tile) { all.add(mesh.template state<splat::Counts>(tile), mesh.template state<splat::Work>(tile)); });
            auto &visible = all[&splat::Counts::visible], &parked = all[&splat::Counts::parked];
            parked += parked_;
            if (host_keeps)
                visible += static_cast<std::uint64_t>(std::count_if(missing_.begin(), missing_.end(),
                                                                    [&](auto row) { return records_.has_row(row); }));
            for (auto const row : under_way_)
                if (records_.has_row(row)) ++(splat_of(row - records_.first_row(), view, tiling).visible() ? visible : parked);
        });
    }
    /// Does any footprint leave its anchor tile? Without bloom, the other tiles then lack it.
    template <class Host>
    bool any_spans(Host& host, splat::Tiling const& tiling) const
    {
        bool any = false;
        auto& mesh = host.mesh();
        auto const& frame = mesh.template broadcast<typename P::Parameters>();
        for_each_tile(host, [&](TileId tile) {
            for (auto const& entry : std::as_const(mesh).template state<splat::Splats<P>>(tile)) {
                auto const& s = splat::AccessOf<P>::splat_of(frame, entry);
                any = any || (s.visible() && splat::tiles_of(s, tiling).count() > 1);
            }
        });
        return host.any(any);
    }
    /// The rectangle of tiles from (0, 0) that hold pixels or may hold records.
    Extent2 occupied() const noexcept { return occupied_; }

    /// Calls f(tile) for every tile of this process that may hold pixels or records.
    template <class Host, class F>
    void for_each_tile(Host const& host, F const& f) const
    {
        for (std::uint32_t y = 0; y < occupied_.height; ++y)
            for (std::uint32_t x = 0; x < occupied_.width; ++x)
                if (auto const tile = TileId::at(x, y); host.has(tile)) f(tile);
    }
    /// From now on the mesh runs these tiles and the tiles that were occupied before. The other tiles are idle.
    template <class Host>
    void occupy(Host& host, std::uint32_t columns, std::uint32_t rows)
    {
        if (columns <= occupied_.width && rows <= occupied_.height) return;
        occupied_ = {std::max(columns, occupied_.width), std::max(rows, occupied_.height)};
        host.mesh().run_within(0, 0, occupied_.width, occupied_.height);
    }

    /// Starts on an empty mesh. With routing it puts all records onto the mesh. It throws Error if they do not fit into `slots` slots of
    /// storage per tile.
    template <class Host>
    void begin(Host& host, splat::Tiling const& tiling, std::uint32_t slots, bool routes = P::routes)
    {
        occupied_ = {};
        occupy(host, tiling.columns, tiling.rows);
        missing_.clear();
        missing_ids_.clear();
        under_way_.clear();
        parked_ = 0;
        if constexpr (P::routes)
            if (routes) load_all(host, tiling, slots);
    }

    /// Puts the missing records onto the mesh, in order. Each tile of the picture gets an even share. A full tile passes its share on to
    /// the next tile, and at last to tiles outside the picture. Records that find no room stay missing. `rendered`: a frame was rendered
    /// before, so a tile may hold a copy of a missing record; the copy then becomes the record.
    template <class Host>
    void load(Host& host, splat::Tiling const& tiling, bool rendered)
    {
        auto const next = load_rows(host, tiling, rendered, missing_.size(), [&](std::uint64_t i) { return missing_[static_cast<std::size_t>(i)]; });
        missing_.erase(missing_.begin(), missing_.begin() + static_cast<std::ptrdiff_t>(next));
        if (!missing_ids_.empty()) missing_ids_.erase(missing_ids_.begin(), missing_ids_.begin() + static_cast<std::ptrdiff_t>(next));
    }

    /// Only without routing: puts the records with something on screen onto their anchor tiles, in order. A record whose tile is full
    /// becomes missing. A record with nothing on screen stays with the host.
    template <class Host>
    void place(Host& host, splat::View const& view, splat::Tiling const& tiling)
    {
        auto& mesh = host.mesh();
        for_each_tile(host, [&](TileId tile) {
            mesh.template state<splat::Storage<P>>(tile).truncate(0);
            mesh.template state<splat::Marks<P>>(tile).truncate(0);
            mesh.template state<splat::Splats<P>>(tile).truncate(0);
            mesh.template state<splat::Counts>(tile).changes = 1;
        });
        parked_ = 0;
        std::vector<Missing> missing;
        host.template to_tiles<Placed>(
            [&](auto const& send) {
                for (std::uint32_t row = 0; row < records_.rows(); ++row) {
                    auto const s = splat_of(row, view, tiling);
                    if (s.visible())
                        send(s.anchor, Placed{records_.first_row() + row, record_of(mesh, row), entry_of(row, s)});
                    else
                        ++parked_;
                }
            },
            [&](TileId tile, Placed const& p) {
                if (!put(mesh, tile, p.record, p.entry)) missing.push_back({p.row, p.record.id});
            });
        host.everywhere(missing, [](Missing const& a, Missing const& b) { return a.row < b.row; });
        host.step([&] {
            missing_.clear();
            missing_ids_.clear();
            for (auto const& m : missing) {
                missing_.push_back(m.row);
                missing_ids_.push_back(m.id);
            }
        });
    }

    /// Removes the copies of missing records from the tiles. Returns whether there were any.
    template <class Host>
    bool recall_copies(Host& host)
    {
        if (missing_.empty()) return false;
        bool any_here = false;
        host.step([&] { any_here = recall_own_copies(host); });
        return host.any(any_here);
    }

private:
    /// A record on its way to its anchor tile, and the entry that the tile has for it.
    struct Placed {
        std::uint32_t row;
        typename P::Record record;
        typename P::Projected entry;
    };
    struct Missing {
        std::uint32_t row;
        splat::GaussianId id;
    };

    /// Puts n rows onto the mesh, in order, as `load`: `row_of(i)` is the i-th one. Returns how many found room.
    template <class Host, class RowOf>
    std::uint64_t load_rows(Host& host, splat::Tiling const& tiling, bool rendered, std::uint64_t rows, RowOf const& row_of)
    {
        auto& mesh = host.mesh();
        auto const grid = mesh.grid();
        auto const in_picture = tiling.columns * tiling.rows;
        auto const share = (rows + in_picture - 1) / in_picture;
        std::uint64_t next = 0, reached[] = {0, 0}; // columns and rows with a new record
        typename Host::template Loading<typename P::Record> loading;
        auto const fill = [&](TileId tile, std::uint64_t most) {
            auto storage = mesh.template state<splat::Storage<P>>(tile);
            auto marks = mesh.template state<splat::Marks<P>>(tile);
            auto splats = mesh.template state<splat::Splats<P>>(tile);
            for (std::uint64_t n = 0; n < most && next < rows; ++n, ++next) {
                auto const row = row_of(next);
                auto const id = missing_ids_.empty() ? splat::GaussianId::none : missing_ids_[static_cast<std::size_t>(next)];
                auto const g = loading.record([&] { return record_of(mesh, row); }, id);
                if constexpr (by_reference) cache_->put(row);
                ++mesh.template state<splat::Counts>(tile).changes;
                auto const copy = rendered ? splat::find(marks, g.id) : splat::no_slot;
                if (copy != splat::no_slot) { // the copy stayed when its record found no room
                    loading.took(row, tile, copy);
                    storage[copy] = g;
                    marks[copy].bits &= ~splat::Mark::copy;
                    continue;
                }
                if (!storage.try_push(g)) return;
                loading.took(row, tile, storage.size() - 1);
                reached[0] = std::max<std::uint64_t>(reached[0], tile.x() + 1);
                reached[1] = std::max<std::uint64_t>(reached[1], tile.y() + 1);
                marks.unchecked_push({g.id, 0});
                splats.unchecked_push(entry_of(row, {}));
            }
        };
        auto const fill_tiles = [&](std::uint32_t tiles, std::uint64_t most, auto const& tile_of) {
            next = host.in_turn(next, [&](std::uint64_t first) {
                next = first;
                for (std::uint32_t i = 0; i < tiles && next < rows; ++i)
                    if (auto const tile = tile_of(i); host.has(tile)) fill(tile, most);
                return next;
            });
        };
        fill_tiles(in_picture, share, [&](std::uint32_t i) { return TileId::at(i % tiling.columns, i / tiling.columns); });
        if (next < rows) fill_tiles(grid.size(), rows, [&](std::uint32_t t) { return grid.tile(t); });
        host.most(reached);
        occupy(host, static_cast<std::uint32_t>(reached[0]), static_cast<std::uint32_t>(reached[1]));
        host.finish(loading, records_, [&](TileId tile, std::uint32_t slot, typename P::Record const& record) {
            mesh.template state<splat::Storage<P>>(tile)[slot] = record;
            mesh.template state<splat::Marks<P>>(tile)[slot].id = record.id;
        });
        return next;
    }
    /// Puts a record onto its anchor tile. Returns false if the tile is full.
    template <class M>
    static bool put(M& mesh, TileId tile, typename P::Record const& g, typename P::Projected const& entry)
    {
        if (!mesh.template state<splat::Storage<P>>(tile).try_push(g)) return false;
        splat::MarkOf<P> mark{};
        mark.id = g.id;
        mesh.template state<splat::Marks<P>>(tile).unchecked_push(mark);
        mesh.template state<splat::Splats<P>>(tile).unchecked_push(entry);
        return true;
    }

    template <class Host>
    bool recall_own_copies(Host& host)
    {
        auto& mesh = host.mesh();
        SortedTable ids;
        for (std::size_t i = 0; i < missing_.size(); ++i)
            ids.add(static_cast<std::uint32_t>(missing_ids_.empty() ? records_.id(missing_[i]) : missing_ids_[i]), missing_[i]);
        (void)ids.sort();
        bool any = false;
        auto const is_orphan = [&](auto const& mark) {
            return mark.is(splat::Mark::copy) && ids.has(static_cast<std::uint32_t>(mark.id));
        };
        for_each_tile(host, [&](TileId tile) {
            auto const seen = std::as_const(mesh).template state<splat::Marks<P>>(tile);
            if (std::none_of(seen.begin(), seen.end(), is_orphan)) return;
            auto storage = mesh.template state<splat::Storage<P>>(tile);
            auto marks = mesh.template state<splat::Marks<P>>(tile);
            auto splats = mesh.template state<splat::Splats<P>>(tile);
            for (std::uint32_t i = storage.size(); i-- > 0;)
                if (is_orphan(marks[i])) {
                    splat::remove_slot(storage, marks, splats, i);
                    ++mesh.template state<splat::Counts>(tile).changes;
                    any = true;
                }
        });
        return any;
    }
    template <class Host>
    void load_all(Host& host, splat::Tiling const& tiling, std::uint32_t slots)
    {
        auto const rows = records_.all_rows();
        auto const tiles = host.mesh().grid().size();
        if (load_rows(host, tiling, false, rows, [](std::uint64_t i) { return static_cast<std::uint32_t>(i); }) < rows)
            throw Error("a map of " + std::to_string(rows) + " Gaussians (" + std::to_string(tiles) + " tiles of " +
                        std::to_string(slots) + " slots hold " + std::to_string(std::uint64_t{tiles} * slots) +
                        "); choose more slots or a larger machine");
    }
    splat::Splat splat_of(std::uint32_t row, splat::View const& view, splat::Tiling const& tiling) const noexcept
    {
        return by_reference ? (*cache_)[row] : project_row(records_, row, view, tiling);
    }
    /// The record that a tile stores for a row; `entry_of`: what it stores for the projected splat.
    template <class M>
    typename P::Record record_of([[maybe_unused]] M& mesh, std::uint32_t row) const noexcept(!splat::stores_own_form<P>)
    {
        if constexpr (by_reference)
            return {records_.id(row), row};
        else if constexpr (splat::stores_own_form<P>)
            return stored(std::as_const(mesh.template broadcast<typename P::Parameters>()), row);
        else
            return records_.template record<typename P::Record>(row);
    }
    /// The form of a row that tiles store. Throws Error if it has no place for that record.
    template <class Parameters>
    typename P::Record stored(Parameters const& parameters, std::uint32_t row) const
    {
        auto const record = splat::AccessOf<P>::template stored<typename P::Record>(records_.gaussians()[row], parameters);
        if (record.id != records_.id(row))
            throw Error("Gaussian " + std::to_string(static_cast<std::uint32_t>(records_.id(row))) +
                        " (the form that tiles store has no place for its numbers); give the renderer records that were rounded to that "
                        "form");
        return record;
    }
    typename P::Projected entry_of([[maybe_unused]] std::uint32_t row, [[maybe_unused]] splat::Splat const& s) const noexcept
    {
        if constexpr (by_reference)
            return {row};
        else
            return typename P::Projected{s};
    }

    Records const& records_;
    ScreenCache* cache_;
    std::vector<std::uint32_t> missing_, under_way_;
    std::vector<splat::GaussianId> missing_ids_; ///< of `missing_`; empty if the table has them
    std::uint64_t parked_ = 0;
    Extent2 occupied_{};
};

}}} // namespace tilemesh::render
