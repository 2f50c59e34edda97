#pragma once
#include <tilemesh/splat/homes/regions.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat::homes {

/// The passes of Tell in a round, on a grid of which columns x rows tiles hold blocks: every tile then knows every window.
constexpr std::uint32_t tell_passes(std::uint32_t grid_columns, std::uint32_t grid_rows) noexcept
{
    return grid_columns + grid_rows - 1;
}

/// Tells every tile the windows of all tiles: first along the rows, one window an exchange and side, then along the columns, one whole row
/// an exchange and side. It runs W + H - 1 times on a grid of W x H tiles, with W + H - 2 exchanges. A tile without blocks passes on and
/// keeps what it is told, because it is a home, too. With districts, a tile keeps the hull of the windows that it is told, and on the
/// columns goes a row of districts: as many exchanges, and fewer words.
template <class P>
struct Tell {
    static constexpr char const* name = "tell";
    using FrameParameters = typename P::Parameters;

    void operator()(Here here, Broadcast<FrameParameters> frame, Window& window, Table& table, Sending& sending, Counts& counts,
                    In<WindowNotices> in, Out<WindowNotices> out) const noexcept
    {
        std::uint32_t const columns = frame->fold.x.tiles, rows = frame->fold.y.tiles;
        std::uint32_t const x = here.tile.x(), y = here.tile.y(), pass = window.pass;
        std::uint32_t const row_passes = here.grid.width - 1, last = row_passes + here.grid.height - 1;
        std::uint32_t const shift = frame->district_shift, across = districts(columns, shift);
        auto const keep = [&](std::uint32_t tx, std::uint32_t ty, WindowNotice const& notice) noexcept {
            if (tx >= columns || ty >= rows) return;
            if constexpr (FrameParameters::has_districts)
                if (shift != 0) return widen(table[(ty >> shift) * across + (tx >> shift)], notice);
            table[ty * columns + tx] = notice;
        };
        if constexpr (FrameParameters::has_districts)
            if (pass == 0 && shift != 0)
                for (WindowNotice& notice : table) notice = {infinite_depth, 0, 0xffffffffu};
        if (pass == 0) {
            WindowNotice const own{window.lo_depth, window.hi_depth, window.finished}; // a tile that is done wants no finite depth
            keep(x, y, own);
            if (row_passes != 0) {
                send_along(here, out, Direction::east, &own, 1);
                send_along(here, out, Direction::west, &own, 1);
            }
        }
        if (pass != 0 && pass <= row_passes) { // one window from each side; those that come from the west are of tile x - pass
            for (Direction from : {Direction::west, Direction::east}) {
                if (in[from].empty()) continue;
                WindowNotice const& notice = in[from][0];
                keep(from == Direction::west ? x - pass : x + pass, y, notice);
                if (pass < row_passes) send_along(here, out, opposite(from), &notice, 1);
            }
        }
        if (pass > row_passes) { // a row of windows from each side
            std::uint32_t const distance = pass - row_passes;
            for (Direction from : {Direction::north, Direction::south}) {
                if (in[from].empty()) continue;
                std::uint32_t const ty = from == Direction::north ? y - distance : y + distance, n = in[from].size();
                if constexpr (FrameParameters::has_districts)
                    for (std::uint32_t i = 0; shift != 0 && i < n && ty < rows; ++i) widen(table[(ty >> shift) * across + i], in[from][i]);
                if (shift == 0) {
                    if (ty < rows) __builtin_memcpy(table.begin() + ty * columns, in[from].begin(), n * sizeof(WindowNotice));
                }
                if (pass < last) send_along(here, out, opposite(from), in[from].begin(), n);
            }
        }
        if (pass == row_passes && pass < last && y < rows)
            for (Direction to : {Direction::north, Direction::south}) send_along(here, out, to, table.begin() + (y >> shift) * across, across);
        window.pass = pass < last ? pass + 1 : 0;
        sending = {};
        counts.left = counts.passed = counts.settled = counts.turned_away = counts.compared = counts.scanned = 0;
    }

    /// For a cost model: a window that is taken or given is a slot.
    static Operations operations(In<WindowNotices> in, Out<WindowNotices> out) noexcept
    {
        Operations o;
        for (Direction d : news) o[Operation::slot] += in[d].size() + out[d].size();
        return o;
    }

private:
    /// Makes `hull` the hull of itself and of a window. A tile that is done wants nothing.
    TILEMESH_KERNEL static void widen(WindowNotice& hull, WindowNotice const& notice) noexcept
    {
        if (notice.lo_depth == infinite_depth) return;
        hull.lo_depth = notice.lo_depth < hull.lo_depth ? notice.lo_depth : hull.lo_depth;
        hull.hi_depth = notice.hi_depth > hull.hi_depth ? notice.hi_depth : hull.hi_depth;
        hull.finished &= notice.finished;
    }
    TILEMESH_KERNEL static void send_along(Here const& here, Out<WindowNotices>& out, Direction d, WindowNotice const* notices,
                                           std::uint32_t n) noexcept
    {
        if (!here.grid.has_neighbour(here.tile, d)) return;
        __builtin_memcpy(out[d].begin(), notices, n * sizeof(WindowNotice));
        out[d].resize(n);
    }
};

}}} // namespace tilemesh::splat::homes
