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
/// each has a keeper of the same records: every process calls the same functions, puts records on its own tiles, and has the same lists.
template <class P>
class RecordKeeper {
public:
    static constexpr bool by_reference = std::is_same_v<typename P::Record, splat::Reference>;

    /// `cache`: the host's table, if tiles hold references to it.
    RecordKeeper(RecordTable const& records, ScreenCache* cache) : records_(records), cache_(cache) {}

    /// The rows that should be on the mesh but are not, in order.
    std::vector<std::uint32_t> const& missing() const noexcept { return missing_; }
    void set_missing(std::vector<std::uint32_t> rows) { missing_ = std::move(rows); }
    /// Takes the rows that are in channels and FIFOs. No tile counts them.
    void set_under_way(std::vector<std::uint32_t> rows) { under_way_ = std::move(rows); }
    /// The number of rows that stay with the host because they have nothing on screen; only without routing.
    std::uint64_t parked() const noexcept { return parked_; }
    /// The visible and the parked rows that no tile counts when a frame starts.
    struct OffTiles {
        std::uint64_t visible = 0, parked = 0;
    };
    /// Counts the rows that the host keeps, and the rows under way. `host_keeps`: the host keeps the missing rows and counts them as
    /// visible until they are placed; otherwise they are lost. Call it with the frame's view, after `load` or `place` and before the `set_`
    /// functions. Cost: one projection per row under way.
    OffTiles off_tiles(splat::View const& view, splat::Tiling const& tiling, bool host_keeps) const
    {
        OffTiles n{host_keeps ? missing_.size() : 0, parked_};
        for (auto const row : under_way_) ++(splat_of(row, view, tiling).visible() ? n.visible : n.parked);
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
    void begin(M& mesh, splat::Tiling const& tiling, std::uint32_t slots)
    {
        occupied_ = {};
        occupy(mesh, tiling.columns, tiling.rows);
        missing_.clear();
        under_way_.clear();
        parked_ = 0;
        if constexpr (P::routes) load_all(mesh, tiling, slots);
    }

    /// Puts the missing records onto the mesh, in order. Each tile of the picture gets an even share. A full tile passes its share on to
    /// the next tile, and at last to tiles outside the picture. Records that find no room stay missing. `rendered`: a frame was rendered
    /// before, so a tile may hold a copy of a missing record; the copy then becomes the record.
    template <class M>
    void load(M& mesh, splat::Tiling const& tiling, bool rendered)
    {
        auto const grid = mesh.grid();
        auto const in_picture = tiling.columns * tiling.rows;
        auto const share = (missing_.size() + in_picture - 1) / in_picture;
        std::uint64_t next = 0, reached[] = {0, 0}; // columns and rows with a new record
        auto const fill = [&](TileId tile, std::size_t most) {
            auto storage = mesh.template state<splat::Storage<P>>(tile);
            auto marks = mesh.template state<splat::Marks<P>>(tile);
            auto splats = mesh.template state<splat::Splats<P>>(tile);
            for (std::size_t n = 0; n < most && next < missing_.size(); ++n, ++next) {
                auto const row = missing_[next];
                auto const g = record_of(row);
                if constexpr (by_reference) cache_->put(row);
                ++mesh.template state<splat::Counts>(tile).changes;
                auto const copy = rendered ? splat::find(marks, g.id) : splat::no_slot;
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
        auto const fill_tiles = [&](std::uint32_t tiles, std::size_t most, auto const& tile_of) {
            next = in_turn(mesh, next, [&](std::uint64_t first) {
                next = first;
                for (std::uint32_t i = 0; i < tiles && next < missing_.size(); ++i)
                    if (auto const tile = tile_of(i); owns(mesh, tile)) fill(tile, most);
                return next;
            });
        };
        fill_tiles(in_picture, share, [&](std::uint32_t i) { return TileId::at(i % tiling.columns, i / tiling.columns); });
        if (next < missing_.size()) fill_tiles(grid.size(), missing_.size(), [&](std::uint32_t t) { return grid.tile(t); });
        most(mesh, reached, 2);
        occupy(mesh, static_cast<std::uint32_t>(reached[0]), static_cast<std::uint32_t>(reached[1]));
        missing_.erase(missing_.begin(), missing_.begin() + static_cast<std::ptrdiff_t>(next));
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
        parked_ = 0;
        together(mesh, [&] { place_own(mesh, view, tiling); });
        if constexpr (over_ranks<M>) { // each process found the records that its own tiles have no room for
            join(mesh, missing_);
            together(mesh, [&] { std::sort(missing_.begin(), missing_.end()); });
            share(mesh, missing_);
        }
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
    template <class M>
    void place_own(M& mesh, splat::View const& view, splat::Tiling const& tiling)
    {
        for (std::uint32_t row = 0; row < records_.rows(); ++row) {
            auto const s = splat_of(row, view, tiling);
            if (!s.visible()) {
                ++parked_;
                continue;
            }
            if (!owns(mesh, s.anchor)) continue;
            auto const g = record_of(row);
            if (!mesh.template state<splat::Storage<P>>(s.anchor).try_push(g)) {
                missing_.push_back(row);
                continue;
            }
            splat::MarkOf<P> mark{};
            mark.id = g.id;
            mesh.template state<splat::Marks<P>>(s.anchor).unchecked_push(mark);
            mesh.template state<splat::Splats<P>>(s.anchor).unchecked_push(entry_of(row, s));
        }
    }

    template <class M>
    bool recall_own_copies(M& mesh)
    {
        SortedTable ids;
        for (auto row : missing_) ids.add(static_cast<std::uint32_t>(records_.id(row)), row);
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
        together(mesh, [&] {
            missing_.resize(records_.rows());
            for (std::uint32_t i = 0; i < records_.rows(); ++i) missing_[i] = i;
        });
        load(mesh, tiling, false);
        auto const tiles = mesh.grid().size();
        if (!missing_.empty())
            throw Error("a map of " + std::to_string(records_.rows()) + " Gaussians (" + std::to_string(tiles) + " tiles of " +
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
    std::uint64_t parked_ = 0;
    Extent2 occupied_{};
};

}}} // namespace tilemesh::render
