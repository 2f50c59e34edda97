#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/render/host_form.hpp>
#include <tilemesh/render/over_ranks.hpp>
#include <tilemesh/render/record_table.hpp>
#include <tilemesh/render/row_shares.hpp>
#include <tilemesh/render/screen_cache.hpp>
#include <tilemesh/render/sorted_table.hpp>
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
/// `P` is a set of policies. Every member function takes the mesh, which must be between two runs. If the mesh runs on several processes,
/// each has a keeper of its share of the rows: every process calls the same functions, puts records on its own tiles, and has the same
/// lists of rows. A process does not need the rows of the others: the rule that gives a row its tile is the same for all numbers of
/// processes, and a row that starts on a tile of another process is sent to it.
template <class P>
class RecordKeeper {
public:
    static constexpr bool by_reference = std::is_same_v<typename P::Record, splat::Reference>;

    /// `cache`: the host's table, if tiles hold references to it.
    RecordKeeper(RecordTable const& records, ScreenCache* cache) : records_(records), cache_(cache) {}

    /// The rows that should be on the mesh but are not, in order.
    std::vector<std::uint32_t> const& missing() const noexcept { return missing_; }
    /// `ids`: the ids of these rows; only for several processes.
    void set_missing(std::vector<std::uint32_t> rows, std::vector<splat::GaussianId> ids = {})
    {
        missing_ = std::move(rows);
        missing_ids_ = std::move(ids);
    }
    /// Takes the rows that are in channels and FIFOs. No tile counts them.
    void set_under_way(std::vector<std::uint32_t> rows) { under_way_ = std::move(rows); }
    /// The number of rows that stay with the host because they have nothing on screen; only without routing. Of this process.
    std::uint64_t parked() const noexcept { return parked_; }
    /// The visible and the parked rows that no tile counts when a frame starts.
    struct OffTiles {
        std::uint64_t visible = 0, parked = 0;
    };
    /// Counts the rows that the host keeps, and the rows under way. `host_keeps`: the host keeps the missing rows and counts them as
    /// visible until they are placed; otherwise they are lost. Call it with the frame's view, after `load` or `place` and before the `set_`
    /// functions. On several processes, it counts the rows of this process. Cost: one projection per row under way.
    OffTiles off_tiles(splat::View const& view, splat::Tiling const& tiling, bool host_keeps) const
    {
        auto const& shares = records_.shares();
        OffTiles n{0, parked_};
        if (host_keeps)
            n.visible = static_cast<std::uint64_t>(std::count_if(missing_.begin(), missing_.end(), [&](auto row) { return shares.is_own(row); }));
        for (auto const row : under_way_)
            if (shares.is_own(row)) ++(splat_of(row - shares.first(), view, tiling).visible() ? n.visible : n.parked);
        return n;
    }
    /// The rectangle of tiles from (0, 0) that hold pixels or may hold records.
    Extent2 occupied() const noexcept { return occupied_; }

    /// Calls f(tile) for every tile of this process that may hold pixels or records.
    template <class M, class F>
    void for_each_tile(M const& mesh, F const& f) const
    {
        for (std::uint32_t y = 0; y < occupied_.height; ++y)
            for (std::uint32_t x = 0; x < occupied_.width; ++x)
                if (auto const tile = TileId::at(x, y); owns(mesh, tile)) f(tile);
    }
    /// From now on the mesh runs these tiles and the tiles that were occupied before. The other tiles are idle.
    template <class M>
    void occupy(M& mesh, std::uint32_t columns, std::uint32_t rows)
    {
        if (columns <= occupied_.width && rows <= occupied_.height) return;
        occupied_ = {std::max(columns, occupied_.width), std::max(rows, occupied_.height)};
        mesh.run_within(0, 0, occupied_.width, occupied_.height);
    }

    /// Starts on an empty mesh. With routing it puts all records onto the mesh. It throws Error if they do not fit into `slots` slots of
    /// storage per tile.
    template <class M>
    void begin(M& mesh, splat::Tiling const& tiling, std::uint32_t slots, bool routes = P::routes)
    {
        occupied_ = {};
        occupy(mesh, tiling.columns, tiling.rows);
        missing_.clear();
        missing_ids_.clear();
        under_way_.clear();
        parked_ = 0;
        if constexpr (P::routes)
            if (routes) load_all(mesh, tiling, slots);
    }

    /// Puts the missing records onto the mesh, in order. Each tile of the picture gets an even share. A full tile passes its share on to
    /// the next tile, and at last to tiles outside the picture. Records that find no room stay missing. `rendered`: a frame was rendered
    /// before, so a tile may hold a copy of a missing record; the copy then becomes the record.
    template <class M>
    void load(M& mesh, splat::Tiling const& tiling, bool rendered)
    {
        auto const next = load_rows(mesh, tiling, rendered, missing_.size(), [&](std::uint64_t i) { return missing_[i]; });
        missing_.erase(missing_.begin(), missing_.begin() + static_cast<std::ptrdiff_t>(next));
        if (!missing_ids_.empty()) missing_ids_.erase(missing_ids_.begin(), missing_ids_.begin() + static_cast<std::ptrdiff_t>(next));
    }

    /// Only without routing: puts the records with something on screen onto their anchor tiles, in order. A record whose tile is full
    /// becomes missing. A record with nothing on screen stays with the host.
    template <class M>
    void place(M& mesh, splat::View const& view, splat::Tiling const& tiling)
    {
        for_each_tile(mesh, [&](TileId tile) {
            mesh.template state<splat::Storage<P>>(tile).truncate(0);
            mesh.template state<splat::Marks<P>>(tile).truncate(0);
            mesh.template state<splat::Splats<P>>(tile).truncate(0);
            mesh.template state<splat::Counts>(tile).changes = 1;
        });
        missing_.clear();
        missing_ids_.clear();
        parked_ = 0;
        if constexpr (over_ranks<M>)
            place_from_all(mesh, view, tiling);
        else
            place_own(mesh, view, tiling);
    }

    /// Removes the copies of missing records from the tiles. Returns whether there were any.
    template <class M>
    bool recall_copies(M& mesh)
    {
        if (missing_.empty()) return false;
        bool any_here = false;
        together(mesh, [&] { any_here = recall_own_copies(mesh); });
        return in_any(mesh, any_here);
    }

private:
    /// A slot that a row of the map has taken.
    struct Taken {
        std::uint32_t row;
        TileId tile;
        std::uint32_t slot;
    };
    /// A record on its way to its anchor tile.
    struct Placed {
        std::uint32_t row;
        typename P::Record record;
        splat::Splat splat;
    };
    struct Missing {
        std::uint32_t row;
        splat::GaussianId id;
    };

    /// Puts n rows onto the mesh, in order, as `load`: `row_of(i)` is the i-th one. Returns how many found room. On several processes, a tile
    /// first takes a slot for a row, and then gets the record from the process that has the row.
    template <class M, class RowOf>
    std::uint64_t load_rows(M& mesh, splat::Tiling const& tiling, bool rendered, std::uint64_t rows, RowOf const& row_of)
    {
        auto const grid = mesh.grid();
        auto const in_picture = tiling.columns * tiling.rows;
        auto const share = (rows + in_picture - 1) / in_picture;
        std::uint64_t next = 0, reached[] = {0, 0}; // columns and rows with a new record
        std::vector<Taken> taken;
        auto const fill = [&](TileId tile, std::uint64_t most) {
            auto storage = mesh.template state<splat::Storage<P>>(tile);
            auto marks = mesh.template state<splat::Marks<P>>(tile);
            auto splats = mesh.template state<splat::Splats<P>>(tile);
            for (std::uint64_t n = 0; n < most && next < rows; ++n, ++next) {
                auto const row = row_of(next);
                typename P::Record g{};
                if constexpr (!over_ranks<M>) g = record_of(row);
                else if (!missing_ids_.empty()) g.id = missing_ids_[next];
                if constexpr (by_reference) cache_->put(row);
                ++mesh.template state<splat::Counts>(tile).changes;
                auto const copy = rendered ? splat::find(marks, g.id) : splat::no_slot;
                if constexpr (over_ranks<M>)
                    if (copy != splat::no_slot || storage.room() != 0)
                        taken.push_back({row, tile, copy != splat::no_slot ? copy : storage.size()});
                if (copy != splat::no_slot) { // the copy stayed when its record found no room
                    storage[copy] = g;
                    marks[copy].bits &= ~splat::Mark::copy;
                    continue;
                }
                if (!storage.try_push(g)) return;
                reached[0] = std::max<std::uint64_t>(reached[0], tile.x() + 1);
                reached[1] = std::max<std::uint64_t>(reached[1], tile.y() + 1);
                marks.unchecked_push({g.id, 0});
                splats.unchecked_push(entry_of(row, {}));
            }
        };
        // The tiles of a process follow those of the process before, so it goes on where that one stopped.
        auto const fill_tiles = [&](std::uint32_t tiles, std::uint64_t most, auto const& tile_of) {
            next = in_turn(mesh, next, [&](std::uint64_t first) {
                next = first;
                for (std::uint32_t i = 0; i < tiles && next < rows; ++i)
                    if (auto const tile = tile_of(i); owns(mesh, tile)) fill(tile, most);
                return next;
            });
        };
        fill_tiles(in_picture, share, [&](std::uint32_t i) { return TileId::at(i % tiling.columns, i / tiling.columns); });
        if (next < rows) fill_tiles(grid.size(), rows, [&](std::uint32_t t) { return grid.tile(t); });
        most(mesh, reached, 2);
        occupy(mesh, static_cast<std::uint32_t>(reached[0]), static_cast<std::uint32_t>(reached[1]));
        if constexpr (over_ranks<M>) fill_slots(mesh, taken);
        return next;
    }
    /// Gets the records of the slots that rows of the map have taken.
    template <class M>
    void fill_slots(M& mesh, std::vector<Taken> const& taken)
    {
        std::vector<std::uint32_t> wanted;
        together(mesh, [&] {
            wanted.reserve(taken.size());
            for (auto const& t : taken) wanted.push_back(t.row);
        });
        auto const records = fetch_rows<typename P::Record>(mesh, records_.shares(), std::move(wanted),
                                                            [&](std::uint32_t row) { return record_of(row - records_.shares().first()); });
        for (std::size_t i = 0; i < taken.size(); ++i) {
            mesh.template state<splat::Storage<P>>(taken[i].tile)[taken[i].slot] = records[i];
            mesh.template state<splat::Marks<P>>(taken[i].tile)[taken[i].slot].id = records[i].id;
        }
    }
    /// `place` on several processes: each projects its rows and sends them to the processes of their anchor tiles.
    template <class M>
    void place_from_all(M& mesh, splat::View const& view, splat::Tiling const& tiling)
    {
        std::vector<Placed> placed;
        std::vector<std::uint64_t> counts;
        together(mesh, [&] {
            counts.assign(processes(mesh), 0);
            for (std::uint32_t row = 0; row < records_.rows(); ++row) {
                auto const s = splat_of(row, view, tiling);
                if (!s.visible()) {
                    ++parked_;
                    continue;
                }
                placed.push_back({records_.shares().first() + row, record_of(row), s});
                ++counts[process_of(mesh, s.anchor)];
            }
            std::stable_sort(placed.begin(), placed.end(), [&](Placed const& a, Placed const& b) {
                return process_of(mesh, a.splat.anchor) < process_of(mesh, b.splat.anchor);
            });
        });
        placed = deal(mesh, std::move(placed), counts); // in the order of rows, because shares follow one another
        std::vector<Missing> missing; // each process found the records that its own tiles have no room for
        together(mesh, [&] {
            for (auto const& p : placed)
                if (!put(mesh, p.splat.anchor, p.record, typename P::Projected(p.splat))) missing.push_back({p.row, p.record.id});
        });
        join(mesh, missing);
        together(mesh, [&] { std::sort(missing.begin(), missing.end(), [](Missing a, Missing b) { return a.row < b.row; }); });
        render::share(mesh, missing);
        together(mesh, [&] {
            for (auto const& m : missing) {
                missing_.push_back(m.row);
                missing_ids_.push_back(m.id);
            }
        });
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
    template <class M>
    void place_own(M& mesh, splat::View const& view, splat::Tiling const& tiling)
    {
        for (std::uint32_t row = 0; row < records_.rows(); ++row) {
            auto const s = splat_of(row, view, tiling);
            if (!s.visible()) {
                ++parked_;
                continue;
            }
            if (!put(mesh, s.anchor, record_of(row), entry_of(row, s))) missing_.push_back(row);
        }
    }

    template <class M>
    bool recall_own_copies(M& mesh)
    {
        SortedTable ids;
        for (std::size_t i = 0; i < missing_.size(); ++i)
            ids.add(static_cast<std::uint32_t>(missing_ids_.empty() ? records_.id(missing_[i]) : missing_ids_[i]), missing_[i]);
        (void)ids.sort();
        bool any = false;
        auto const is_orphan = [&](auto const& mark) {
            return mark.is(splat::Mark::copy) && ids.has(static_cast<std::uint32_t>(mark.id));
        };
        for_each_tile(mesh, [&](TileId tile) {
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
    template <class M>
    void load_all(M& mesh, splat::Tiling const& tiling, std::uint32_t slots)
    {
        auto const rows = records_.all_rows();
        auto const tiles = mesh.grid().size();
        if (load_rows(mesh, tiling, false, rows, [](std::uint64_t i) { return static_cast<std::uint32_t>(i); }) < rows)
            throw Error("a map of " + std::to_string(rows) + " Gaussians (" + std::to_string(tiles) + " tiles of " +
                        std::to_string(slots) + " slots hold " + std::to_string(std::uint64_t{tiles} * slots) +
                        "); choose more slots or a larger machine");
    }
    splat::Splat splat_of(std::uint32_t row, splat::View const& view, splat::Tiling const& tiling) const noexcept
    {
        return by_reference ? (*cache_)[row] : records_.project(row, view, tiling);
    }
    /// The entry that tiles store for a row; `entry_of`: for its projected splat.
    typename P::Record record_of(std::uint32_t row) const noexcept
    {
        if constexpr (by_reference)
            return {records_.id(row), row};
        else
            return records_.template record<typename P::Record>(row);
    }
    typename P::Projected entry_of([[maybe_unused]] std::uint32_t row, [[maybe_unused]] splat::Splat const& s) const noexcept
    {
        if constexpr (by_reference)
            return {row};
        else
            return typename P::Projected(s);
    }

    RecordTable const& records_;
    ScreenCache* cache_;
    std::vector<std::uint32_t> missing_, under_way_;
    std::vector<splat::GaussianId> missing_ids_; ///< of several processes, because a row's id is with its process
    std::uint64_t parked_ = 0;
    Extent2 occupied_{};
};

}}} // namespace tilemesh::render
