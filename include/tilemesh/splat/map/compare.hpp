#pragma once
#include <cstdint>
#include <cstring>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/splat/depth_sort.hpp>
#include <tilemesh/splat/map/operations.hpp>
#include <tilemesh/splat/map/regions.hpp>
#include <tilemesh/splat/operations.hpp>

/// The middle steps of a mapping step: each tile compares its pixels with the target, and adds up the sums of its splats. No exchange.
namespace tilemesh { inline namespace v0_2 { namespace splat::map {

/// Lists the entries that touch the tile's pixels, front to back: by depth, then by id. It also makes room for the sums.
struct SortEntries {
    static constexpr char const* name = "sort entries";
    void operator()(Here here, Broadcast<StepParameters> step, Entries const& entries, EntrySums& totals, EntryKeys& keys,
                    BlockLosses& losses, TreeState& tree, MapCounts& counts) const noexcept
    {
        std::uint32_t const n = entries.size();
        for (std::uint32_t i = 0; i < n; ++i) {
            Entry const& e = entries[i];
            tree.ready += e.can_answer() ? 1 : 0;
            if (!e.splat.visible()) continue;
            counts.visible += i < tree.own ? 1 : 0;
            if (!touches(e.splat.rect(), step->tiling, here.tile)) continue;
            keys.push({e.splat.depth_key, e.id, i});
        }
        splat::detail::sort_all(keys.begin(), keys.size(), keys.capacity());
        totals.resize(times(step->walkers, n));
        losses.resize(blocks_of(step->tiling));
        for (BlockLoss& loss : losses) loss = {};
    }
    /// For a cost model.
    static splat::Operations operations(Entries const& entries, EntryKeys const& keys) noexcept
    {
        std::uint32_t levels = 0;
        while (levels < 31 && (1u << levels) < keys.size()) ++levels;
        splat::Operations o;
        o[splat::Operation::slot] = entries.size();
        o[splat::Operation::comparison] = times(keys.size(), levels);
        return o;
    }
};

/// Both walks over the tile's pixels (tile.hpp): blends the picture with `precise` arithmetic, makes the slopes of its loss, and adds up
/// the sums of each entry. The first `walkers` workers share the blocks; each adds to its own sums.
struct Walk {
    static constexpr char const* name = "walk";
    static constexpr std::uint32_t most_workers = most_walkers;
    void operator()(Here here, Broadcast<StepParameters> step, Entries const& entries, EntryKeys const& keys, TargetPixels const& target,
                    EntrySums& totals, BlockLosses& losses, WalkWork& work, WalkSpaces& spaces, Worker worker) const noexcept
    {
        if (worker.index >= step->walkers) {
            work.blended[worker.index] = 0;
            return;
        }
        share<splat::detail::native_lanes>(spaces[worker.index].memory(), here, *step, entries, keys, target, totals, losses, work,
                                           worker.index);
    }
    /// For a cost model. All workers wait for the one with the most.
    static Operations operations(Broadcast<StepParameters> step, Entries const& entries, TargetPixels const& target, WalkWork const& work,
                                 Worker worker) noexcept
    {
        std::uint32_t const pairs = times(work.most(step->walkers), worker.count * block_width * block_height);
        Operations o;
        o[Operation::map_pair] = pairs;
        o[Operation::walked_pair] = pairs;
        o[Operation::pixel_slope] = (target.size() + step->walkers - 1) / step->walkers * worker.count;
        o[Operation::gathered] = times((entries.size() + 3) / 4, worker.count); // to clear takes a quarter of adding
        return o;
    }
    /// The shares of all workers, one after the other: each has its own sums. A template, as `ProjectRecords::OnOneThread` is.
    template <class>
    struct OnOneThread {
        static constexpr char const* name = Walk::name;
        void operator()(Here here, Broadcast<StepParameters> step, Entries const& entries, EntryKeys const& keys,
                        TargetPixels const& target, EntrySums& totals, BlockLosses& losses, WalkWork& work, WalkSpaces&,
                        Worker worker) const noexcept
        {
            WalkMemory<8, 128> memory;
            for (std::uint32_t w = 0; w < worker.count; ++w)
                if (w < step->walkers)
                    share<splat::detail::lanes_in_use>(memory, here, *step, entries, keys, target, totals, losses, work, w);
                else
                    work.blended[w] = 0;
        }
    };
    using AllWorkers = OnOneThread<void>;

private:
    template <std::uint32_t Lanes, class Memory>
    static void share(Memory& memory, Here const& here, StepParameters const& step, Entries const& entries, EntryKeys const& keys,
                      TargetPixels const& target, EntrySums& totals, BlockLosses& losses, WalkWork& work, std::uint32_t w) noexcept
    {
        auto const tile = pixels_of(step.tiling, step.view.camera, here.tile);
        std::uint32_t const n = entries.size(), across = step.tiling.tile_width / block_width;
        SplatSums* const mine = totals.begin() + w * n;
        BlockLoss* const loss_of = losses.begin();
        for (std::uint32_t i = 0; i < n; ++i) mine[i] = {};
        std::uint32_t blended = 0;
        walk_tile<Lanes>(
            memory, tile, step.view.camera, WalkRules{step.view.rules, step.loss}, keys.size(),
            [&](std::uint32_t i) noexcept -> Splat const& { return entries[keys[i].slot].splat; }, target.begin(), tile.x1 - tile.x0,
            Worker{w, step.walkers},
            [&](BlendedBlock const& block, BlockLoss const& loss) noexcept {
                std::uint32_t const row = (static_cast<std::uint32_t>(block.at.row) - tile.y0) / block_height;
                loss_of[row * across + (static_cast<std::uint32_t>(block.at.column) - tile.x0) / block_width] = loss;
                blended += block.blended;
                return true;
            },
            [&](std::uint32_t i, SplatSums const& s) noexcept { mine[keys[i].slot] += s; });
        work.blended[w] = blended;
    }
};

/// Adds the sums of the other workers to those of the first. The slots are dealt to the workers.
struct AddUp {
    static constexpr char const* name = "add up";
    void operator()(Broadcast<StepParameters> step, Entries const& entries, EntrySums& totals, Worker worker) const noexcept
    {
        std::uint32_t const n = entries.size();
        for (std::uint32_t w = 1; w < step->walkers; ++w)
            for (std::uint32_t i = worker.index; i < n; i += worker.count) totals[i] += totals[w * n + i];
    }
    /// For a cost model. All workers wait for the one with the most.
    static Operations operations(Broadcast<StepParameters> step, Entries const& entries, Worker worker) noexcept
    {
        Operations o;
        o[Operation::gathered] = times(times((entries.size() + worker.count - 1) / worker.count, worker.count), step->walkers - 1);
        return o;
    }
    struct AllWorkers {
        static constexpr char const* name = AddUp::name;
        void operator()(Broadcast<StepParameters> step, Entries const& entries, EntrySums& totals, Worker) const noexcept
        {
            AddUp{}(step, entries, totals, Worker{0, 1});
        }
    };
};

}}} // namespace tilemesh::splat::map
