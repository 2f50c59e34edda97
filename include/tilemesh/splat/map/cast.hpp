#pragma once
#include <cstdint>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/splat/harmonics.hpp>
#include <tilemesh/splat/map/operations.hpp>
#include <tilemesh/splat/map/regions.hpp>
#include <tilemesh/splat/operations.hpp>
#include <tilemesh/splat/project_all.hpp>

/// The first steps of a mapping step: each record is projected where it rests, and its copies go to all tiles that it touches.
namespace tilemesh { inline namespace v0_2 { namespace splat::map {

/// Forgets the last view, and makes room for the splats of the tile's own records. A record that finds no slot is left out and counted.
struct BeginView {
    static constexpr char const* name = "begin view";
    void operator()(Records const& records, Entries& entries, EntrySums& totals, EntryKeys& keys, TreeState& tree,
                    MapCounts& counts) const noexcept
    {
        std::uint32_t const own = records.size() < entries.capacity() ? records.size() : entries.capacity();
        entries.resize(own);
        totals.resize(0);
        keys.resize(0);
        tree = {own, 0, 0};
        counts = {};
        counts.no_entry = records.size() - own;
    }
};

/// Projects the first n records on one host thread, many at once: f(i, splat of record i).
template <class F>
void project_each(Records const& records, std::uint32_t n, StepParameters const& step, F const& f) noexcept
{
    constexpr std::uint32_t at_once = 64;
    Splat splats[at_once];
    for (std::uint32_t begin = 0; begin < n; begin += at_once) {
        std::uint32_t const left = n - begin, some = left < at_once ? left : at_once;
        project_all(records.begin() + begin, some, step.view, step.tiling, splats);
        for (std::uint32_t i = 0; i < some; ++i) f(begin + i, splats[i]);
    }
}

/// Projects the records on all workers: entry i is the splat of record i.
struct ProjectRecords {
    static constexpr char const* name = "project records";
    void operator()(Here here, Broadcast<StepParameters> step, Records const& records, Entries& entries, Worker worker) const noexcept
    {
        for (std::uint32_t i = worker.index; i < entries.size(); i += worker.count)
            set(entries[i], project(records[i], step->view, step->tiling), records[i].id, *step, here.tile);
    }
    /// For a cost model. A projection's price is that of one worker; all work at once, and wait for the one with the most.
    static splat::Operations operations(Broadcast<StepParameters> step, Entries const& entries, Worker worker) noexcept
    {
        splat::Operations o;
        o[splat::Operation::projection] = projections_through(step->view.camera, (entries.size() + worker.count - 1) / worker.count);
        return o;
    }
    /// A template, so that programs for tiles have no word that says which instruction set a host has.
    template <class>
    struct OnOneThread {
        static constexpr char const* name = ProjectRecords::name;
        void operator()(Here here, Broadcast<StepParameters> step, Records const& records, Entries& entries, Worker) const noexcept
        {
            project_each(records, entries.size(), *step,
                         [&](std::uint32_t i, Splat const& s) { set(entries[i], s, records[i].id, *step, here.tile); });
        }
    };
    using AllWorkers = OnOneThread<void>;

    static void set(Entry& e, Splat const& s, GaussianId id, StepParameters const& step, TileId here) noexcept
    {
        std::uint32_t const sides = s.visible() ? child_sides_of(s.rect(), step.tiling, here, at_root) : 0;
        e = {s, id, 0, sides | sides << 4};
    }
};
/// `ProjectRecords` for records with harmonics: a splat has the colour that the camera sees from its position.
template <class Optimiser>
struct ProjectShaded {
    static constexpr char const* name = ProjectRecords::name;
    void operator()(Here here, Broadcast<StepParameters> step, Records const& records, OptimiserStates<Optimiser> const& states,
                    Entries& entries, Worker worker) const noexcept
    {
        for (std::uint32_t i = worker.index; i < entries.size(); i += worker.count)
            set(entries[i], project(records[i], step->view, step->tiling), records[i], states[i], *step, here.tile);
    }
    /// For a cost model, as `ProjectRecords`. A splat that nothing shows is not shaded.
    static ShadedOperations operations(Broadcast<StepParameters> step, Entries const& entries, Worker worker) noexcept
    {
        std::uint32_t shaded = 0;
        for (std::uint32_t w = 0; w < worker.count; ++w) {
            std::uint32_t mine = 0;
            for (std::uint32_t i = w; i < entries.size(); i += worker.count) mine += entries[i].splat.visible() ? 1 : 0;
            shaded = mine > shaded ? mine : shaded;
        }
        ShadedOperations o;
        o[ShadedOperation::projection] = projections_through(step->view.camera, (entries.size() + worker.count - 1) / worker.count);
        o[ShadedOperation::harmonic] = times(shaded, worker.count * (Optimiser::words / 3));
        return o;
    }
    /// A template, as `ProjectRecords::OnOneThread` is.
    template <class>
    struct OnOneThread {
        static constexpr char const* name = ProjectShaded::name;
        void operator()(Here here, Broadcast<StepParameters> step, Records const& records, OptimiserStates<Optimiser> const& states,
                        Entries& entries, Worker) const noexcept
        {
            project_each(records, entries.size(), *step,
                         [&](std::uint32_t i, Splat const& s) { set(entries[i], s, records[i], states[i], *step, here.tile); });
        }
    };
    using AllWorkers = OnOneThread<void>;

private:
    static void set(Entry& e, Splat s, Gaussian const& g, typename Optimiser::State const& state, StepParameters const& step,
                    TileId here) noexcept
    {
        if (s.visible() && !shade<Optimiser::degree>(g, state.harmonics, step.view, s)) s = {};
        ProjectRecords::set(e, s, g.id, step, here);
    }
};

/// Sends copies along the trees. The entries are the sink: a copy that arrives is stored, or, if the tile is full, answered at once with
/// empty sums. Answers that arrive come from full tiles.
///
/// A tile sends no more copies to a side in a pass than an end of `Answers` has slots, so the receiver can answer all of them. Any
/// capacities of at least 1 end. Cost: 64 bytes a copy; as many supersteps as the deepest tree has levels, if no channel fills.
struct Cast {
    static constexpr char const* name = "cast";
    Vote operator()(Here here, Broadcast<StepParameters> step, Entries& entries, TreeState& tree, MapCounts& counts, Passed& passed,
                    In<Copies> in, Out<Copies> out, In<Answers> answered, Out<Answers> answer) const noexcept
    {
        for (Direction d : news)
            for (AnswerMessage const& a : answered[d]) {
                entries[a.slot].bits &= ~Entry::waits(d);
                ++passed.moved;
            }
        for (Direction d : news)
            for (CopyMessage const& c : in[d]) {
                ++passed.moved;
                std::uint32_t const sides = child_sides_of(c.splat.rect(), step->tiling, here.tile, index(d));
                if (entries.try_push({c.splat, c.id, c.slot, Entry::from(d) | sides | sides << 4})) {
                    ++counts.copies;
                } else {
                    answer[d].push({c.slot, {}});
                    ++counts.copies_full;
                }
            }
        std::uint32_t const n = entries.size();
        std::uint32_t first = n;
        for (std::uint32_t i = tree.first_owing; i < n; ++i) {
            ++passed.looked;
            Entry& e = entries[i];
            if ((e.bits & Entry::owes_any) == 0) continue;
            for (Direction d : news) {
                if ((e.bits & Entry::owes(d)) == 0) continue;
                if (out[d].size() < answer[d].capacity() && out[d].try_push({e.splat, e.id, i})) {
                    e.bits &= ~Entry::owes(d);
                    ++passed.moved;
                } else {
                    ++counts.cast_held;
                }
            }
            if ((e.bits & Entry::owes_any) != 0 && i < first) first = i;
        }
        tree.first_owing = first;
        return first < n ? Vote::busy : Vote::quiet;
    }
    /// For a cost model.
    static Operations operations(Passed const& passed) noexcept
    {
        Operations o;
        o[Operation::slot] = passed.looked;
        o[Operation::cast_copy] = passed.moved;
        return o;
    }
};

}}} // namespace tilemesh::splat::map
