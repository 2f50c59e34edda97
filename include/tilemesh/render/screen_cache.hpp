#pragma once
#include <algorithm>
#include <cstdint>
#include <tilemesh/render/project_records.hpp>
#include <tilemesh/render/record_table.hpp>
#include <tilemesh/splat/references.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// The host's table of a map's projected records in one view. The host projects each record once, even if several tiles hold it.
///
/// In each new view, one or several threads call `project`, each for its own rows. Then `point` gives the tiles the address of the table.
/// Cost: 85 bytes per record, in addition to the record.
class ScreenCache {
public:
    ScreenCache() = default;
    explicit ScreenCache(std::uint32_t rows)
        : splats_(rows), touched_(rows), before_(rows, splat::TileSpan::all()), depths_(rows),
          row_states_(rows, splat::RowState::moved | splat::RowState::appeared)
    {
    }
    splat::Splat const& operator[](std::uint32_t row) const noexcept { return splats_[row]; }
    std::uint32_t rows() const noexcept { return static_cast<std::uint32_t>(splats_.size()); }

    /// Projects the rows [first, last) of `records`, and notes for each row what changed since the view of the last call. `first_view`:
    /// there was no last call. The type of the parameters may change the projected splats (`Access::adjust`).
    template <class Parameters>
    void project(RecordTable const& records, std::uint32_t first, std::uint32_t last, splat::View const& view,
                 splat::Tiling const& tiling, bool first_view, Parameters const& parameters) noexcept
    {
        for (std::uint32_t from = first; from < last; from += at_once) {
            auto const to = std::min(from + at_once, last);
            project_rows(records, from, to - from, view, tiling, splats_.data() + from);
            splat::Access<Parameters>::adjust(parameters, view, tiling, splats_.data() + from, to - from);
            compare(from, to, tiling, first_view);
        }
    }
    /// Call this when the host puts a row onto the mesh. The row's tile then looks at the row in this view.
    void put(std::uint32_t row) noexcept
    {
        before_[row] = splat::TileSpan::all();
        row_states_[row] |= splat::RowState::moved | splat::RowState::appeared;
    }

    /// Writes the address of the table into the tiles' parameters. `copies_where_touched`: this is the first run in a new view, and a tile
    /// has copies only of records that touched it in the view before.
    void point(splat::TableParameters& p, bool copies_where_touched) const noexcept
    {
        p.before = splat::HostPointer<splat::TileSpan const>(copies_where_touched ? before_.data() : nullptr);
        p.splats = splat::HostPointer<splat::Splat const>(splats_.data());
        p.touched = splat::HostPointer<splat::TouchedTiles const>(touched_.data());
        p.row_states = splat::HostPointer<std::uint8_t const>(row_states_.data());
        p.depths = splat::HostPointer<std::uint32_t const>(depths_.data());
    }

private:
    static constexpr std::uint32_t at_once = 256; // so that the splats are still in the nearest cache when `compare` reads them

    /// At most `at_once` rows.
    void compare(std::uint32_t from, std::uint32_t to, splat::Tiling const& tiling, bool first_view) noexcept
    {
        // Without a branch that depends on a row: it notes the states of all rows, and collects the rows that moved.
        std::uint32_t moved[at_once], n = 0;
        for (auto row = from; row < to; ++row) {
            auto const& s = splats_[row];
            std::uint32_t const shows = s.visible() ? 1u : 0u, other = first_view ? 1u : shows ^ touched_[row].visible;
            std::uint32_t const same = (other ^ 1u) & ((shows ^ 1u) | stays(touched_[row], s, tiling));
            depths_[row] = shows != 0 ? s.depth_key : 0;
            row_states_[row] = static_cast<std::uint8_t>(shows * splat::RowState::visible + (same ^ 1u) * splat::RowState::moved +
                                                         other * splat::RowState::appeared);
            moved[n] = row;
            n += same ^ 1u;
        }
        for (std::uint32_t k = 0; k < n; ++k) {
            auto const& s = splats_[moved[k]];
            auto const& old = touched_[moved[k]];
            // A record that was not visible lies on any tile, and so do all records before the first view. They may leave copies there.
            before_[moved[k]] = old.visible != 0 && !first_view ? splat::TileSpan{old.first, old.last} : splat::TileSpan::all();
            if (!s.visible()) {
                touched_[moved[k]] = {};
                continue;
            }
            auto const range = splat::tiles_of(s, tiling);
            touched_[moved[k]] = {range.first, range.last, s.anchor, 1};
        }
    }
    /// 1 if a visible splat touches the same tiles as before, with the same anchor; otherwise 0. The test needs no division.
    static std::uint32_t stays(splat::TouchedTiles const& old, splat::Splat const& s, splat::Tiling const& tiling) noexcept
    {
        auto const r = s.rect();
        auto const within = [](std::uint32_t px, std::uint32_t tile, std::uint32_t size) {
            return px - tile * size < size ? 1u : 0u;
        };
        return within(r.x0, old.first.x(), tiling.tile_width) & within(r.x1 - 1, old.last.x(), tiling.tile_width) &
               within(r.y0, old.first.y(), tiling.tile_height) & within(r.y1 - 1, old.last.y(), tiling.tile_height) &
               (s.anchor == old.anchor ? 1u : 0u);
    }

    std::vector<splat::Splat> splats_;
    std::vector<splat::TouchedTiles> touched_;
    std::vector<splat::TileSpan> before_; ///< of the rows that moved in this view
    std::vector<std::uint32_t> depths_;
    std::vector<std::uint8_t> row_states_;
};

}}} // namespace tilemesh::render
