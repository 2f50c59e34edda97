#pragma once
#include <limits>
#include <tilemesh/splat/compositing.hpp>
#include <tilemesh/splat/pose/operations.hpp>
#include <tilemesh/splat/pose/regions.hpp>
#include <tilemesh/splat/pose/tile.hpp>
#include <utility>

/// Rows from the gradients of the composited picture, instead of forward mode: a pixel moves as the point of the map that it shows.
TILEMESH_EXACT_BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi" // see lanes.hpp
namespace tilemesh { inline namespace v0_2 { namespace splat::pose {

/// A cell of the picture and of the target: means over its pixels. Colours of cells that the frame's edge cuts are NaN, so that neither the
/// cell nor its neighbours count. A depth that is not known is 0.
struct CellPixel {
    float rgb[3], depth;
    float seen[3]; ///< the target's colour
    float weight;  ///< the share that the splats cover
    float seen_depth;
};
/// The words of a cell that its neighbours read.
struct EdgeCell {
    float rgb[3], depth;
    float seen[3];
};

namespace region {
template <class P>
struct Cells : Buffer<CellPixel> {
    static constexpr char const* name = "cells";
    static constexpr auto slots = &Sizes::tile_pixels;
};
} // namespace region
template <class S>
using Cells = region::Cells<PoliciesOf<S>>;

/// The most cells along a side of a tile that is evaluated by gradients.
inline constexpr std::uint32_t most_cells_a_side = 64;
/// The outermost cells of the neighbours. At the frame's edge there are none.
struct Ring : Channel<EdgeCell, most_cells_a_side, Edge::drop> {
    static constexpr char const* name = "ring of cells";
};

namespace detail {
/// The cells of a tile: its pixels over the size of a cell, rounded up.
struct CellGrid {
    std::uint32_t width, height;
    TILEMESH_KERNEL CellGrid(PixelRect const& tile, std::uint32_t cell) noexcept
        : width((tile.x1 - tile.x0 + cell - 1) / cell), height((tile.y1 - tile.y0 + cell - 1) / cell)
    {
    }
};
TILEMESH_KERNEL EdgeCell edge_of(CellPixel const& c) noexcept
{
    return {{c.rgb[0], c.rgb[1], c.rgb[2]}, c.depth, {c.seen[0], c.seen[1], c.seen[2]}};
}
/// The mean of the pixels [x0, x0 + cell) by [y0, y0 + cell) of a tile's rectangle. Depths are weighted by the share that is covered; the
/// target's depth is the mean of those that are known, if they are more than half.
template <class Pixel>
CellPixel mean_cell(Pixel const* pixels, TargetPixel const* target, PixelRect const& tile, std::uint32_t x0, std::uint32_t y0,
                    std::uint32_t cell) noexcept
{
    std::uint32_t const width = tile.x1 - tile.x0, height = tile.y1 - tile.y0;
    CellPixel c{};
    if (x0 + cell > width || y0 + cell > height) {
        for (float& v : c.rgb) v = std::numeric_limits<float>::quiet_NaN();
        return c;
    }
    if (cell == 1) {
        Pixel const& p = pixels[y0 * width + x0];
        TargetPixel const& t = target[y0 * width + x0];
        for (std::uint32_t k = 0; k < 3; ++k) c.rgb[k] = p.colour.colour.rgb[k], c.seen[k] = t.rgb[k];
        c.weight = p.alpha;
        c.depth = p.alpha > least_coverage ? p.colour.depth : 0.0f;
        c.seen_depth = t.depth > 0 ? t.depth : 0.0f;
        return c;
    }
    float depth = 0, known = 0;
    for (std::uint32_t y = y0; y < y0 + cell; ++y)
        for (std::uint32_t x = x0; x < x0 + cell; ++x) {
            Pixel const& p = pixels[y * width + x];
            TargetPixel const& t = target[y * width + x];
            for (std::uint32_t k = 0; k < 3; ++k) c.rgb[k] += p.colour.colour.rgb[k], c.seen[k] += t.rgb[k];
            c.weight += p.alpha;
            depth += p.alpha * p.colour.depth;
            if (t.depth > 0) c.seen_depth += t.depth, known += 1;
        }
    float const share = 1.0f / static_cast<float>(cell * cell);
    c.depth = c.weight * share > least_coverage ? depth / c.weight : 0.0f;
    c.seen_depth = 2 * known * share > 1 ? c.seen_depth / known : 0.0f;
    c.weight *= share;
    for (float& v : c.rgb) v *= share;
    for (float& v : c.seen) v *= share;
    return c;
}

/// Up to 16 cells in a row, one more on each side, field by field: cell i has index i + 1.
struct CellLine {
    float rgb[3][block_width + 2], depth[block_width + 2], seen[3][block_width + 2];
    float weight[block_width + 2], seen_depth[block_width + 2]; ///< the weight of a cell that is not evaluated is 0

    void set(std::uint32_t i, EdgeCell const& c) noexcept
    {
        for (std::uint32_t k = 0; k < 3; ++k) rgb[k][i] = c.rgb[k], seen[k][i] = c.seen[k];
        depth[i] = c.depth;
        weight[i] = 0;
    }
    void set(std::uint32_t i, CellPixel const& c) noexcept
    {
        for (std::uint32_t k = 0; k < 3; ++k) rgb[k][i] = c.rgb[k], seen[k][i] = c.seen[k];
        depth[i] = c.depth, weight[i] = c.weight, seen_depth[i] = c.seen_depth;
    }
};
/// A row of cells between its neighbours.
struct Neighbourhood {
    CellLine lines[3];     ///< a ring: row y of the tile's cells is line (y + 1) % 3
    float x[block_width]; ///< the cell's column in the frame
    CellLine const& line(std::uint32_t y, std::uint32_t below) const noexcept { return lines[(y + below) % 3]; } ///< 0: the row above
};

/// The rows of a Neighbourhood in row `row` of the tile's cells, which is row `y` of the frame's.
struct MakeGradientRows {
    template <class Set>
    TILEMESH_KERNEL static void run(Neighbourhood const& from, std::uint32_t row, float y, Camera const& camera, Tracking const& t,
                                    CellRows& rows) noexcept
    {
        using namespace splat::detail;
        CellLine const &above = from.line(row, 0), &own = from.line(row, 1), &below = from.line(row, 2);
        constexpr std::uint32_t N = Set::most_lanes;
        using A = FloatLanes<N>;
        auto const& rules = t.sums;
        float const per_cell = 1.0f / static_cast<float>(t.cell); // exact: a power of two
        Floats<N> const zero{}, one = broadcast<N>(1.0f), most = broadcast<N>(1e18f);
        Floats<N> const fx = broadcast<N>(camera.fx * per_cell), fy = broadcast<N>(camera.fy * per_cell);
        for (std::uint32_t column = 0; column < block_width; column += N) {
            // How the point in the middle of the cell moves in the picture, in cells.
            Floats<N> const depth = load<N>(own.depth + column + 1), per_z = one / depth;
            Floats<N> sx = (load<N>(from.x + column) + 0.5f - camera.cx * per_cell) / fx;
            Floats<N> sy = broadcast<N>(y + 0.5f - camera.cy * per_cell) / fy;
            bool const by_angle = camera.lens.kind == LensKind::fisheye, bends = camera.lens.kind != LensKind::pinhole && !by_angle;
            if (bends) {
                Floats<N> const u = sx, v = sy;
                unbend<A>(camera.lens, u, v, sx, sy);
            }
            Floats<N> du[motions] =
                {fx * per_z, zero, -(fx * sx * per_z), -(fx * sx * sy), fx * multiply_add_lanes<N>(sx, sx, one), -(fx * sy)};
            Floats<N> dv[motions] = {zero, fy * per_z, -(fy * sy * per_z), -(fy * multiply_add_lanes<N>(sy, sy, one)), fy * sx * sy, fy * sx};
            if (bends) {
                BentSlopes<A> const at(camera.lens, sx, sy);
                Floats<N> const d01 = at.d01 * (fx / fy), d10 = at.d01 * (fy / fx);
                for (std::uint32_t j = 0; j < motions; ++j) {
                    Floats<N> const along = du[j], down = dv[j];
                    du[j] = multiply_add_lanes<N>(at.d00, along, d01 * down);
                    dv[j] = multiply_add_lanes<N>(d10, along, at.d11 * down);
                }
            }
            Floats<N> dz[motions] = {zero, zero, one, sy * depth, -(sx * depth), zero};
            if (by_angle) {
                FisheyePoint<A> const at(camera, sx, sy, depth, camera.fx * per_cell, camera.fy * per_cell);
                move<Column::rho_x>(at, du, dv), move<Column::rho_y>(at, du, dv), move<Column::rho_z>(at, du, dv);
                move<Column::phi_x>(at, du, dv), move<Column::phi_y>(at, du, dv), move<Column::phi_z>(at, du, dv);
                dz[0] = at.ray.x, dz[1] = at.ray.y, dz[2] = at.ray.z, dz[3] = dz[4] = zero;
            }
            Words<N> counts = (load<N>(own.weight + column + 1) > least_coverage) & (depth > 0.0f);
            Floats<N> residual[3], gained[3], motion[3][motions];
            for (std::uint32_t c = 0; c < 3; ++c) {
                gained[c] = rules.gain * load<N>(own.rgb[c] + column + 1);
                residual[c] = gained[c] + rules.offset - load<N>(own.seen[c] + column + 1);
                Floats<N> gx = 0.5f * rules.gain * (load<N>(own.rgb[c] + column + 2) - load<N>(own.rgb[c] + column));
                Floats<N> gy = 0.5f * rules.gain * (load<N>(below.rgb[c] + column + 1) - load<N>(above.rgb[c] + column + 1));
                if (t.gradients == 2) {
                    gx = 0.5f * gx + 0.25f * (load<N>(own.seen[c] + column + 2) - load<N>(own.seen[c] + column));
                    gy = 0.5f * gy + 0.25f * (load<N>(below.seen[c] + column + 1) - load<N>(above.seen[c] + column + 1));
                }
                counts &= A::magnitude(residual[c]) < most;
                for (std::uint32_t j = 0; j < motions; ++j) {
                    motion[c][j] = -(gx * du[j] + gy * dv[j]);
                    if (j < 3) motion[c][j] = motion[c][j] * rules.scene_depth;
                    counts &= A::magnitude(motion[c][j]) < most;
                }
            }
            for (std::uint32_t c = 0; c < 3; ++c) {
                store(rows.residual[c] + column, A::select(counts, residual[c], zero));
                store(rows.gained[c] + column, A::select(counts, gained[c], zero));
                for (std::uint32_t j = 0; j < motions; ++j) store(rows.motion[c][j] + column, A::select(counts, motion[c][j], zero));
            }
            store(rows.counted + column, A::select(counts, one, zero));
            if (t.with_depth == 0) continue;

            // The depth's gradients are those of the rendered depth alone: a target's depth has holes.
            Floats<N> const seen = load<N>(own.seen_depth + column + 1), off = (depth - seen) / seen;
            Floats<N> const east = load<N>(own.depth + column + 2), west = load<N>(own.depth + column);
            Floats<N> const south = load<N>(below.depth + column + 1), north = load<N>(above.depth + column + 1);
            Words<N> deep = counts & (seen > 0.0f) & (east > 0.0f) & (west > 0.0f) & (south > 0.0f) & (north > 0.0f) & (A::magnitude(off) < most);
            Floats<N> const gx = 0.5f * (east - west), gy = 0.5f * (south - north);
            Floats<N> moves[motions];
            for (std::uint32_t j = 0; j < motions; ++j) {
                moves[j] = (dz[j] - (gx * du[j] + gy * dv[j])) / seen;
                if (j < 3) moves[j] = moves[j] * rules.scene_depth;
                deep &= A::magnitude(moves[j]) < most;
            }
            store(rows.residual[CellRows::depth_channel] + column, A::select(deep, off, zero));
            for (std::uint32_t j = 0; j < motions; ++j) store(rows.motion[CellRows::depth_channel][j] + column, A::select(deep, moves[j], zero));
            store(rows.depth_counted + column, A::select(deep, one, zero));
        }
    }

private:
    template <Column J, class A>
    TILEMESH_KERNEL static void move(FisheyePoint<A> const& at, typename A::Real (&du)[motions], typename A::Real (&dv)[motions]) noexcept
    {
        auto const moved = at.template moved<J>();
        constexpr auto column = static_cast<std::uint32_t>(J);
        du[column] = splat::detail::dot(at.row[0], moved), dv[column] = splat::detail::dot(at.row[1], moved);
    }
};
} // namespace detail

namespace kernel {
template <class S>
struct SendCells {
    static constexpr char const* name = "send cells";
    void operator()(Here here, Broadcast<typename S::Parameters> frame, Broadcast<Tracking> tracking, Framebuffer<S> const& framebuffer,
                    Target<S> const& target, Cells<S>& cells, Out<Ring> out) const noexcept
    {
        auto const tile = pixels_of(frame->tiling, frame->view.camera, here.tile);
        cells.truncate(0);
        if (tile.empty()) return;
        detail::CellGrid const grid(tile, tracking->cell);
        for (std::uint32_t y = 0; y < grid.height; ++y)
            for (std::uint32_t x = 0; x < grid.width; ++x)
                cells.unchecked_push(detail::mean_cell(framebuffer.begin(), target.begin(), tile, x * tracking->cell, y * tracking->cell,
                                                       tracking->cell));
        for (std::uint32_t x = 0; x < grid.width; ++x) {
            out[Direction::north].push(detail::edge_of(cells[x]));
            out[Direction::south].push(detail::edge_of(cells[(grid.height - 1) * grid.width + x]));
        }
        for (std::uint32_t y = 0; y < grid.height; ++y) {
            out[Direction::west].push(detail::edge_of(cells[y * grid.width]));
            out[Direction::east].push(detail::edge_of(cells[y * grid.width + grid.width - 1]));
        }
    }
    /// For a cost model.
    static Operations operations(Target<S> const& target) noexcept
    {
        Operations o;
        o[Operation::mean] = target.size();
        return o;
    }
};
template <class S>
struct AddGradients {
    static constexpr char const* name = "add gradients";
    static constexpr bool has_region = !has_host_stack<typename S::Parameters>;

    void operator()(Here here, Broadcast<typename S::Parameters> frame, Broadcast<Tracking> tracking, Cells<S> const& cells,
                    [[maybe_unused]] OnlyIf<has_region, Workspaces&> workspaces, TileTotals& totals, In<Ring> in) const noexcept
    {
        if constexpr (has_region) {
            add(here, *frame, *tracking, cells, workspaces.of[0].made, workspaces.of[0].sums, totals, in);
        } else {
            CellRows rows;
            LaneSums sums;
            add(here, *frame, *tracking, cells, rows, sums, totals, in);
        }
    }
    /// For a cost model. Cells of blocks that are not chosen make no rows.
    static Operations operations(Broadcast<Tracking> tracking, TileTotals const& totals) noexcept
    {
        std::uint32_t counted = 0;
        for (auto const& one : totals.of) counted += one.cells;
        Operations o;
        o[Operation::gradient] = rows_of(counted, *tracking);
        return o;
    }

private:
    static void add(Here const& here, typename S::Parameters const& frame, Tracking const& tracking, Cells<S> const& cells, CellRows& rows,
                    LaneSums& sums, TileTotals& totals, In<Ring> const& in) noexcept
    {
        auto const tile = pixels_of(frame.tiling, frame.view.camera, here.tile);
        for (auto& one : totals.of) one = {};
        if (tile.empty()) return;
        auto const cell = tracking.cell;
        detail::CellGrid const grid(tile, cell);
        float const nan = std::numeric_limits<float>::quiet_NaN();
        EdgeCell const none{{nan, nan, nan}, 0, {nan, nan, nan}};
        auto const ring = [&](Direction d, std::uint32_t i) noexcept { return i < in[d].size() ? in[d][i] : none; };
        splat::detail::SetOf<has_region ? splat::detail::native_lanes : splat::detail::lanes_in_use> const set{};
        rows = {};
        sums = {};
        detail::Neighbourhood around{};
        // Row y of the tile's cells from column x0 - 1 on, or a neighbour's; `y` may be one outside.
        auto const fill = [&](std::uint32_t x0, std::uint32_t y) noexcept {
            auto& line = around.lines[(y + 1) % 3];
            bool const inside = y < grid.height;
            for (std::uint32_t i = 0; i < block_width + 2; ++i) {
                std::uint32_t const x = x0 + i - 1; // x0 - 1 wraps to a number that is no column
                if (inside && x < grid.width) line.set(i, cells[y * grid.width + x]);
                else if (inside) line.set(i, i == 0 ? ring(Direction::west, y) : x == grid.width ? ring(Direction::east, y) : none);
                else line.set(i, x < grid.width ? ring(y == grid.height ? Direction::south : Direction::north, x) : none);
                if (tracking.one_in > 1 && inside && x < grid.width && !is_chosen(tracking, tile.x0 + x * cell, tile.y0 + y * cell))
                    line.weight[i] = 0;
            }
        };
        for (std::uint32_t x0 = 0; x0 < grid.width; x0 += block_width) {
            for (std::uint32_t i = 0; i < block_width; ++i) around.x[i] = static_cast<float>(tile.x0 / cell + x0 + i);
            fill(x0, ~0u); // the row above
            fill(x0, 0);
            for (std::uint32_t y = 0; y < grid.height; ++y) {
                fill(x0, y + 1);
                set.template call<detail::MakeGradientRows>(around, y, static_cast<float>(tile.y0 / cell + y), frame.view.camera, tracking, rows);
                if (tracking.unknowns > motions)
                    set.template call<detail::AddRows<most_unknowns>>(std::as_const(rows), tracking.sums, sums);
                else
                    set.template call<detail::AddRows<motions>>(std::as_const(rows), tracking.sums, sums); // the code of forward mode
                if (y % block_height == block_height - 1 || y + 1 == grid.height) take_sums(sums, tracking.unknowns, totals.of[0]);
            }
        }
    }
};
} // namespace kernel

/// Averages the composited picture and the target over cells, and sends the outermost cells to the neighbours. Cost: one exchange of at most
/// 64 messages of 28 bytes a side.
template <class S>
using SendCells = kernel::SendCells<PoliciesOf<S>>;
/// Adds up the rows of a tile's cells by the gradients of the picture, J = -(gx du + gy dv) at the depth of the picture, or by their mean with
/// those of the target. A cell needs its four neighbours, so the outermost cells of the frame do not count.
template <class S>
using AddGradients = kernel::AddGradients<PoliciesOf<S>>;

}}} // namespace tilemesh::splat::pose
#pragma GCC diagnostic pop
TILEMESH_EXACT_END
