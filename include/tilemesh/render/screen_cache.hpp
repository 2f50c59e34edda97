#pragma once
#include <algorithm>
#include <cstdint>
#include <tilemesh/render/host_form.hpp>
#include <tilemesh/render/record_table.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// The host's table of a map's projected records in one view. The host projects each record once, even if several tiles hold it.
///
/// In each new view, one or several threads call `project`, each for its own rows. Then `point` gives the tiles the address of the table.
/// Cost: 77 bytes per record, in addition to the record.
class ScreenCache {
public:
    ScreenCache() = default;
    explicit ScreenCache(std::uint32_t rows)
        : splats_(rows), touched_(rows), depths_(rows), row_states_(rows, splat::RowState::moved | splat::RowState::appeared)
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
        constexpr std::uint32_t at_once = 256; // so that the splats are still in the nearest cache when `compare` reads them
        for (std::uint32_t from = first; from < last; from += at_once) {
            auto const to = std::min(from + at_once, last);
            records.project(from, to - from, view, tiling, splats_.data() + from);
            splat::Access<Parameters>::adjust(parameters, view, tiling, splats_.data() + from, to - from);
            compare(from, to, tiling, first_view);
        }
    }
    /// Call this when the host puts a row onto the mesh. The row's tile then looks at the row in this view.
    void put(std::uint32_t row) noexcept { row_states_[row] |= splat::RowState::moved | splat::RowState::appeared; }

    /// Writes the address of the table into the tiles' parameters.
    void point(splat::TableParameters& p) const noexcept
    {
        p.splats = splat::HostPointer<splat::Splat>(splats_.data());
        p.touched = splat::HostPointer<splat::TouchedTiles>(touched_.data());
        p.row_states = splat::HostPointer<std::uint8_t>(row_states_.data());
        p.depths = splat::HostPointer<std::uint32_t>(depths_.data());
    }

private:
    void compare(std::uint32_t from, std::uint32_t to, splat::Tiling const& tiling, bool first_view) noexcept
    {
        for (auto row = from; row < to; ++row) {
            auto const& s = splats_[row];
            std::uint32_t depth;
            __builtin_memcpy(&depth, &s.depth, sizeof depth);
            depths_[row] = depth;
            bool const shows = s.visible();
            auto& old = touched_[row];
            bool const same = !first_view && shows == (old.visible != 0) && (!shows || stays(old, s, tiling));
            if (same) {
                row_states_[row] = shows ? splat::RowState::visible : 0;
                continue;
            }
            row_states_[row] =
                static_cast<std::uint8_t>(splat::RowState::moved | (shows ? splat::RowState::visible : 0) |
                                          (first_view || shows != (old.visible != 0) ? splat::RowState::appeared : 0));
            if (shows) {
                auto const range = splat::tiles_of(s, tiling);
                old = {range.first, range.last, s.anchor, 1};
            } else {
                old = {};
            }
        }
    }
    /// Does a visible splat touch the same tiles as before, with the same anchor? The test needs no division.
    static bool stays(splat::TouchedTiles const& old, splat::Splat const& s, splat::Tiling const& tiling) noexcept
    {
        auto const r = s.rect();
        auto const within = [](std::uint32_t px, std::uint32_t tile, std::uint32_t size) {
            return px - tile * size < size ? 1u : 0u;
        };
        return (within(r.x0, old.first.x(), tiling.tile_width) & within(r.x1 - 1, old.last.x(), tiling.tile_width) &
                within(r.y0, old.first.y(), tiling.tile_height) & within(r.y1 - 1, old.last.y(), tiling.tile_height) &
                (s.anchor == old.anchor ? 1u : 0u)) != 0;
    }

    std::vector<splat::Splat> splats_;
    std::vector<splat::TouchedTiles> touched_;
    std::vector<std::uint32_t> depths_;
    std::vector<std::uint8_t> row_states_;
};

}}} // namespace tilemesh::render
