#pragma once
#include <cstdint>
#include <tilemesh/machine/buffer.hpp>
#include <tilemesh/machine/channel.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/machine/superstep.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/map/compare.hpp>
#include <tilemesh/splat/map/insert.hpp>
#include <tilemesh/splat/map/operations.hpp>
#include <tilemesh/splat/map/program.hpp>
#include <tilemesh/splat/map/regions.hpp>
#include <tilemesh/splat/map/rest.hpp>
#include <tilemesh/splat/map/tile.hpp>
#include <tilemesh/splat/target_pixel.hpp>
#include <tilemesh/splat/view.hpp>
#include <type_traits>

/// A map that grows on the mesh: at a keyframe, each tile inserts Gaussians in the cells of its pixels, and removes faded ones from its
/// records, by the rules of insert.hpp.
namespace tilemesh { inline namespace v0_2 { namespace splat::map {

/// What the host tells every tile of a keyframe.
struct GrowParameters {
    static constexpr char const* name = "growth parameters";
    InsertRules insert;
    RemoveRules remove;
    float scene_depth;      ///< the median depth of the scene in world units
    std::uint32_t keyframe; ///< its number, from 1
    std::uint32_t views;    ///< 1: the tiles get the splats of the view; a step and an insertion need them
    std::uint32_t inserts;  ///< 1: the tiles insert where the picture does not explain the target
    std::uint32_t removes;  ///< 1: the tiles remove faint and huge Gaussians
};
static_assert(std::is_trivially_copyable_v<GrowParameters> && sizeof(GrowParameters) % 4 == 0, "parameters are whole words");

/// What the map shows in the tile's pixels, row by row of its own rectangle.
struct ShownPixels : Buffer<ShownPixel> {
    static constexpr char const* name = "shown pixels";
    static constexpr auto slots = &MapSizes::tile_pixels;
};
/// The sums of the cells that begin above the tile, of their rows above it, from west to east.
struct CutCells : Buffer<CellSums> {
    static constexpr char const* name = "cells from above";
    static constexpr auto slots = &MapSizes::cells;
};
/// The sums of cells on their way to the tile below. They go from west to east, so a message needs no number. 36 bytes.
struct CellRoad : Channel<CellSums, dynamic_capacity, Edge::drop, Sides::south> {
    static constexpr char const* name = "cells on their way";
    static constexpr auto slots = &MapSizes::cell_slots;
};
static_assert(sizeof(CellSums) == 36 && std::is_trivially_copyable_v<CellSums>, "messages are whole words");
/// The cells whose sums the tile has sent.
struct CellState {
    static constexpr char const* name = "state of the cells";
    std::uint32_t sent;
};
/// What a keyframe did on a tile.
struct GrowCounts {
    static constexpr char const* name = "counters of growth";
    std::uint32_t inserted; ///< Gaussians of the last insertion
    std::uint32_t refused;  ///< cells of the last insertion that wanted a Gaussian, and found no slot for it
    std::uint32_t removed;  ///< Gaussians that the last removal took
};
/// What a pass of a keyframe's kernels did.
struct GrowPassed {
    static constexpr char const* name = "counters of a pass of growth";
    static constexpr bool per_pass = true;
    std::uint32_t pixels, moved, made;
};
/// The operations of growth, for a cost model.
struct GrowOperation {
    enum Kind : std::uint32_t {
        cell_pixel, ///< a pixel that is added to the sums of its cell
        moved_cell, ///< the sums of a cell that are taken from a channel or given to one
        new_record, ///< a Gaussian that is made from a cell
        judged      ///< a record that may be removed
    };
    static constexpr char const* names[] = {"cell_pixel", "moved_cell", "new_record", "judged"};
};
using GrowOperations = tilemesh::Operations<GrowOperation>;

/// The cells of a tile. Its columns of cells are whole, because cells divide the width of a tile; rows of cells may begin above or end
/// below.
struct TileCells {
    PixelRect tile;
    CellGrid grid;
    std::uint32_t first_column, columns; ///< none for a tile outside of the picture
    std::uint32_t height;                ///< of the picture

    static TileCells of(StepParameters const& step, std::uint32_t cell, TileId here) noexcept
    {
        auto const& c = step.view.camera;
        auto const tile = pixels_of(step.tiling, c, here);
        return {tile, CellGrid::of(c.width, c.height, cell), tile.x0 / cell, (tile.x1 - tile.x0 + cell - 1) / cell, c.height};
    }
    /// The row of cells that goes on below the tile; `grid.rows` if none does.
    std::uint32_t cut_row() const noexcept
    {
        return columns != 0 && tile.y1 < height && tile.y1 % grid.cell != 0 ? tile.y1 / grid.cell : grid.rows;
    }
    bool begins_above(std::uint32_t row) const noexcept { return row * grid.cell < tile.y0; }
    /// Does the last row of pixels of this row of cells lie in the tile or above?
    bool ends_here(std::uint32_t row) const noexcept { return (row + 1) * grid.cell <= tile.y1 || (tile.y1 == height && row < grid.rows); }
    /// Adds the pixels of a cell that lie in the tile, row by row: the order of the host. Returns how many.
    std::uint32_t add_pixels(CellSums& to, std::uint32_t row, std::uint32_t column, TargetPixel const* target,
                             ShownPixel const* seen) const noexcept
    {
        std::uint32_t const x0 = (first_column + column) * grid.cell, x1 = x0 + grid.cell < tile.x1 ? x0 + grid.cell : tile.x1;
        std::uint32_t const top = row * grid.cell, bottom = top + grid.cell;
        std::uint32_t const y0 = top < tile.y0 ? tile.y0 : top, y1 = bottom < tile.y1 ? bottom : tile.y1;
        for (std::uint32_t y = y0; y < y1; ++y)
            for (std::uint32_t x = x0; x < x1; ++x) {
                std::uint32_t const at = (y - tile.y0) * (tile.x1 - tile.x0) + x - tile.x0;
                to.add(target[at], seen[at]);
            }
        return (x1 - x0) * (y1 - y0);
    }
};

/// Forgets the cells of the last keyframe, and makes room for the pixels of this one.
struct BeginCells {
    static constexpr char const* name = "begin cells";
    void operator()(TargetPixels const& target, ShownPixels& pixels, CutCells& cut, CellState& state) const noexcept
    {
        pixels.resize(target.size());
        cut.resize(0);
        state = {0};
    }
};

/// The first walk alone: what the map shows in each of the tile's pixels. The first `walkers` workers share the blocks.
struct Look {
    static constexpr char const* name = "look";
    static constexpr std::uint32_t most_workers = most_walkers;
    void operator()(Here here, Broadcast<StepParameters> step, Entries const& entries, EntryKeys const& keys, TargetPixels const& target,
                    ShownPixels& pixels, WalkWork& work, WalkSpaces& spaces, Worker worker) const noexcept
    {
        if (worker.index < step->walkers)
            share<splat::detail::native_lanes>(spaces[worker.index].memory(), here, *step, entries, keys, target, pixels, work,
                                               worker.index);
        else
            work.blended[worker.index] = 0;
    }
    /// For a cost model. All workers wait for the one with the most.
    static Operations operations(Broadcast<StepParameters> step, TargetPixels const& target, WalkWork const& work, Worker worker) noexcept
    {
        Operations o;
        o[Operation::map_pair] = times(work.most(step->walkers), worker.count * block_width * block_height);
        o[Operation::pixel_slope] = (target.size() + step->walkers - 1) / step->walkers * worker.count;
        return o;
    }
    /// A template, as `ProjectRecords::OnOneThread` is.
    template <class>
    struct OnOneThread {
        static constexpr char const* name = Look::name;
        void operator()(Here here, Broadcast<StepParameters> step, Entries const& entries, EntryKeys const& keys,
                        TargetPixels const& target, ShownPixels& pixels, WalkWork& work, WalkSpaces&, Worker worker) const noexcept
        {
            WalkMemory<8, 128> memory;
            for (std::uint32_t w = 0; w < worker.count; ++w)
                if (w < step->walkers)
                    share<splat::detail::lanes_in_use>(memory, here, *step, entries, keys, target, pixels, work, w);
                else
                    work.blended[w] = 0;
        }
    };
    using AllWorkers = OnOneThread<void>;

private:
    template <std::uint32_t Lanes, class Memory>
    static void share(Memory& memory, Here const& here, StepParameters const& step, Entries const& entries, EntryKeys const& keys,
                      TargetPixels const& target, ShownPixels& pixels, WalkWork& work, std::uint32_t w) noexcept
    {
        auto const tile = pixels_of(step.tiling, step.view.camera, here.tile);
        ShownPixel* const to = pixels.begin();
        std::uint32_t blended = 0;
        walk_tile<Lanes>(
            memory, tile, step.view.camera, WalkRules{step.view.rules, step.loss}, keys.size(),
            [&](std::uint32_t i) noexcept -> Splat const& { return entries[keys[i].slot].splat; }, target.begin(), tile.x1 - tile.x0,
            Worker{w, step.walkers},
            [&](BlendedBlock const& block, BlockLoss const&) noexcept {
                for (std::uint32_t y = block.live.y0; y < block.live.y1; ++y)
                    for (std::uint32_t x = block.live.x0; x < block.live.x1; ++x)
                        to[(y - tile.y0) * (tile.x1 - tile.x0) + x - tile.x0] = shown(pixel_of(block, x, y), step.view.rules.background);
                blended += block.blended;
                return false;
            },
            [](std::uint32_t, SplatSums const&) noexcept {});
        work.blended[w] = blended;
    }
};

/// Adds up the cells that go on below the tile, and sends their sums there. A cell that begins above waits for its sums. So a cell's
/// pixels are added in the order of the host, wherever tiles cut it. Any capacity of at least 1 ends.
///
/// Cost: 36 bytes a cell and border that cuts it. A tile whose rows are whole cells sends nothing.
struct PassCells {
    static constexpr char const* name = "pass cells";
    Vote operator()(Here here, Broadcast<StepParameters> step, Broadcast<GrowParameters> grow, TargetPixels const& target,
                    ShownPixels const& pixels, CutCells& cut, CellState& state, GrowPassed& passed, In<CellRoad> in,
                    Out<CellRoad> out) const noexcept
    {
        for (CellSums const& above : in[Direction::north]) {
            cut.push(above);
            ++passed.moved;
        }
        auto const cells = TileCells::of(*step, grow->insert.cell, here.tile);
        std::uint32_t const row = cells.cut_row();
        if (row == cells.grid.rows) return Vote::quiet;
        bool const waits = cells.begins_above(row);
        std::uint32_t i = state.sent;
        for (; i < cells.columns && out[Direction::south].room() != 0; ++i) {
            if (waits && i >= cut.size()) break;
            CellSums cell = waits ? cut[i] : CellSums();
            passed.pixels += cells.add_pixels(cell, row, i, target.begin(), pixels.begin());
            out[Direction::south].push(cell);
            ++passed.moved;
        }
        state.sent = i;
        return i < cells.columns && !(waits && i >= cut.size()) ? Vote::busy : Vote::quiet; // mail wakes the others
    }
    /// For a cost model.
    static GrowOperations operations(GrowPassed const& passed) noexcept
    {
        GrowOperations o;
        o[GrowOperation::cell_pixel] = passed.pixels;
        o[GrowOperation::moved_cell] = passed.moved;
        return o;
    }
};

/// Inserts a Gaussian in each cell that wants one, row by row. A cell belongs to the tile with its last row of pixels, and the Gaussian
/// rests there, with an optimiser state that has seen no step.
///
/// A tile whose records are full refuses the Gaussians of all further cells, and counts them (`GrowCounts::refused`). Which cells are
/// refused depends on the tiles and their slots alone: not on channels, threads or engines.
template <class Optimiser>
struct InsertCells {
    static constexpr char const* name = "insert cells";
    void operator()(Here here, Broadcast<StepParameters> step, Broadcast<GrowParameters> grow, TargetPixels const& target,
                    ShownPixels const& pixels, CutCells const& cut, Records& records, OptimiserStates<Optimiser>& states,
                    GrowCounts& counts, GrowPassed& passed) const noexcept
    {
        counts.inserted = counts.refused = 0;
        auto const cells = TileCells::of(*step, grow->insert.cell, here.tile);
        if (cells.columns == 0) return;
        for (std::uint32_t row = cells.tile.y0 / cells.grid.cell; cells.ends_here(row); ++row)
            for (std::uint32_t i = 0; i < cells.columns; ++i) {
                CellSums cell = cells.begins_above(row) ? cut[i] : CellSums();
                passed.pixels += cells.add_pixels(cell, row, i, target.begin(), pixels.begin());
                if (!cell.wants_gaussian(grow->insert)) continue;
                if (records.room() == 0) {
                    ++counts.refused;
                    continue;
                }
                records.push(gaussian_of_cell(cell, step->view.camera, cells.grid, cells.first_column + i, row, grow->keyframe,
                                              grow->insert));
                states.push({});
                ++counts.inserted;
                ++passed.made;
            }
    }
    /// For a cost model.
    static GrowOperations operations(GrowPassed const& passed) noexcept
    {
        GrowOperations o;
        o[GrowOperation::cell_pixel] = passed.pixels;
        o[GrowOperation::new_record] = passed.made;
        return o;
    }
};

/// Removes the records that are faint or huge. The order of a tile's records changes, which changes no bit.
template <class Optimiser>
struct RemoveFaded {
    static constexpr char const* name = "remove faded";
    void operator()(Broadcast<GrowParameters> grow, Records& records, OptimiserStates<Optimiser>& states, GrowCounts& counts,
                    GrowPassed& passed) const noexcept
    {
        counts.removed = 0;
        for (std::uint32_t i = 0; i < records.size();) {
            ++passed.moved;
            if (!is_removed(records[i], grow->remove, grow->scene_depth)) {
                ++i;
                continue;
            }
            records.swap_remove(i);
            states.swap_remove(i);
            ++counts.removed;
        }
    }
    /// For a cost model.
    static GrowOperations operations(GrowPassed const& passed) noexcept
    {
        GrowOperations o;
        o[GrowOperation::judged] = passed.moved;
        return o;
    }
};

/// `MapStep` for a map that grows: a run may move the records, insert Gaussians by a keyframe, step by a view, and remove Gaussians, in
/// this order. The host says which of them with five words of `StepParameters` and `GrowParameters`. A run that inserts does not step: the
/// view has no splats of the new records.
///
/// After the same keyframes and steps, the records have the bits of `slam::Mapper`'s, as long as no tile refused a Gaussian
/// (`GrowCounts`) and no entry is lost (`MapCounts`).
template <class Optimiser>
using GrowStep = Sequence<If<&StepParameters::rests, RestRecords<Optimiser>>, If<&GrowParameters::views, CastView<Optimiser>>,
                          If<&GrowParameters::inserts, Superstep<BeginCells>, Superstep<Look>, Superstep<PassCells>, UntilQuiet<PassCells>,
                             Superstep<InsertCells<Optimiser>>>,
                          If<&StepParameters::steps, WalkAndStep<Optimiser>>,
                          If<&GrowParameters::removes, Superstep<RemoveFaded<Optimiser>>>>;

}}} // namespace tilemesh::splat::map
