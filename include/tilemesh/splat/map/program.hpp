#pragma once
#include <cstdint>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/machine/superstep.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/splat/map/cast.hpp>
#include <tilemesh/splat/map/chain.hpp>
#include <tilemesh/splat/map/compare.hpp>
#include <tilemesh/splat/map/optimise.hpp>
#include <tilemesh/splat/map/regions.hpp>
#include <tilemesh/splat/map/rest.hpp>
#include <type_traits>

/// A mapping step as a program on the mesh: one view moves each Gaussian that it shows.
namespace tilemesh { inline namespace v0_2 { namespace splat::map {

/// Returns the sums up the trees. A copy that has the answers of all tiles to which it was sent has the sums of all of them; it sends them
/// to its parent. So each copy sends one message over one hop. Messages go only to parents, and the entries are the sink: any capacity of
/// at least 1 ends.
///
/// Cost: 44 bytes a copy; as many supersteps as the deepest tree has levels, if no channel fills.
struct Return {
    static constexpr char const* name = "return";
    Vote operator()(Entries& entries, EntrySums& totals, TreeState& tree, MapCounts& counts, Passed& passed, In<Answers> in,
                    Out<Answers> out) const noexcept
    {
        for (Direction d : news)
            for (AnswerMessage const& a : in[d]) {
                Entry& e = entries[a.slot];
                totals[a.slot] += a.sums;
                e.bits &= ~Entry::waits(d);
                tree.ready += e.can_answer() ? 1 : 0;
                ++passed.moved;
            }
        std::uint32_t ready = tree.ready;
        for (std::uint32_t i = tree.own, left = ready; left != 0 && i < entries.size(); ++i) {
            ++passed.looked;
            Entry& e = entries[i];
            if (!e.can_answer()) continue;
            --left;
            if (out[e.parent_side()].try_push({e.parent, totals[i]})) {
                e.bits |= Entry::answered;
                --ready;
                ++passed.moved;
            } else {
                ++counts.return_held;
            }
        }
        tree.ready = ready;
        return ready != 0 ? Vote::busy : Vote::quiet;
    }
    /// For a cost model.
    static Operations operations(Passed const& passed) noexcept
    {
        Operations o;
        o[Operation::slot] = passed.looked;
        o[Operation::returned] = passed.moved;
        return o;
    }
};

/// Moves each record whose sums are not all 0: the chain rule, then the optimiser (`mapping::Refiner` does the same).
template <class Optimiser>
struct TakeStep {
    static constexpr char const* name = "take step";
    void operator()(Broadcast<StepParameters> step, Records& records, OptimiserStates<Optimiser>& states, Entries const& entries,
                    EntrySums const& totals, TreeState const& tree, Worker worker) const noexcept
    {
        for (std::uint32_t i = worker.index; i < tree.own; i += worker.count) {
            if (totals[i].empty()) continue;
            RecordSlopes slopes;
            auto const moments = moments_of(totals[i], entries[i].splat, step->view.rules.dilation, step->loss.limit);
            if (!slopes_of(records[i], step->view, moments, slopes)) continue;
            if constexpr (degree_of<Optimiser> != 0)
                Optimiser::step(records[i], step->view, slopes, step->rates, step->decays, states[i]);
            else
                Optimiser::step(records[i], slopes, step->rates, step->decays, states[i]);
        }
    }
    /// For a cost model. All workers wait for the one with the most.
    static auto operations(EntrySums const& totals, TreeState const& tree, Worker worker) noexcept
    {
        std::uint32_t most = 0;
        for (std::uint32_t w = 0; w < worker.count; ++w) {
            std::uint32_t mine = 0;
            for (std::uint32_t i = w; i < tree.own; i += worker.count) mine += totals[i].empty() ? 0 : 1;
            most = mine > most ? mine : most;
        }
        using Kinds = std::conditional_t<degree_of<Optimiser> == 0, Operation, ShadedOperation>;
        tilemesh::Operations<Kinds> o;
        o[Kinds::slot] = tree.own;
        o[Kinds::chain] = times(most, worker.count);
        if constexpr (degree_of<Optimiser> != 0) o[Kinds::harmonic] = times(most, worker.count * (Optimiser::words / 3));
        return o;
    }
    struct AllWorkers {
        static constexpr char const* name = TakeStep::name;
        void operator()(Broadcast<StepParameters> step, Records& records, OptimiserStates<Optimiser>& states, Entries const& entries,
                        EntrySums const& totals, TreeState const& tree, Worker) const noexcept
        {
            TakeStep{}(step, records, states, entries, totals, tree, Worker{0, 1});
        }
    };
};

/// The splats of a view on all tiles that they touch, in the order of depth.
template <class Optimiser>
using CastView =
    Sequence<Superstep<BeginView>, Superstep<std::conditional_t<degree_of<Optimiser> == 0, ProjectRecords, ProjectShaded<Optimiser>>>,
             Superstep<Cast>, UntilQuiet<Cast>, Superstep<SortEntries>>;
/// The walks, the way back of the sums, and the step of each record.
template <class Optimiser>
using WalkAndStep = Sequence<Superstep<Walk>, Superstep<AddUp>, Superstep<Return>, UntilQuiet<Return>, Superstep<TakeStep<Optimiser>>>;

/// One step of a map by one view. Records rest on any tiles, whatever the view. Each step casts new copies, because each step moves the
/// records. Before the step, or without one, the records may move to the tiles of their means in the view (`RestRecords`): the host says so
/// with two words of `StepParameters`.
///
/// After the same views and steps, the records have the bits of `mapping::Refiner`, for any tile of whole blocks, any resting tiles, any
/// channel capacity and any engine, as long as no entry is lost (`MapCounts`). For harmonics, `Optimiser` is a `Shaded`.
template <class Optimiser>
using MapStep = Sequence<If<&StepParameters::rests, RestRecords<Optimiser>>,
                         If<&StepParameters::steps, CastView<Optimiser>, WalkAndStep<Optimiser>>>;

/// The bytes of a record, and of an entry, on a tile with `walkers` workers that walk.
template <class Optimiser>
inline constexpr std::uint32_t record_bytes = sizeof(Gaussian) + sizeof(typename Optimiser::State) + sizeof(TileId);
constexpr std::uint32_t entry_bytes(std::uint32_t walkers) noexcept
{
    return sizeof(Entry) + sizeof(SortKey) + walkers * static_cast<std::uint32_t>(sizeof(SplatSums));
}
/// The sizes of a program, as `MapStep`, for tiles with room for `records` records: entries get all SRAM that the other regions leave, 0
/// if they leave none.
///
/// `cell`: the side of the cells in which the map grows (grow.hpp); it divides the width of a tile.
template <class Optimiser, template <class> class ProgramOf = MapStep>
constexpr MapSizes sizes_on(MachineSize const& machine, TileSize const& tile, std::uint32_t records, std::uint32_t channel_slots,
                            std::uint32_t cell = 0) noexcept
{
    MapSizes sizes;
    sizes.records = records;
    sizes.copies = sizes.answers = channel_slots;
    sizes.road = times(channel_slots, sizeof(CopyMessage)) / sizeof(RecordMessage<Optimiser>); // in the memory of copies
    if (sizes.road == 0) sizes.road = 1;
    sizes.tile_pixels = tile.tile_width * tile.tile_height;
    sizes.tile_blocks = blocks_of(tile);
    sizes.walkers = walkers_of(tile, machine.workers);
    if (cell != 0) sizes.cells = tile.tile_width / cell;
    sizes.cell_slots = sizes.cells < channel_slots ? sizes.cells : channel_slots;
    auto const used = SramLedger<ProgramOf<Optimiser>>::bytes(machine, sizes);
    auto const left = used < machine.sram_bytes ? machine.sram_bytes - used : 0;
    sizes.entries = static_cast<std::uint32_t>(left / entry_bytes(sizes.walkers));
    sizes.sums = sizes.entries * sizes.walkers;
    return sizes;
}

}}} // namespace tilemesh::splat::map
