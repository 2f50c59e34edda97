#pragma once
#include <cstdint>
#include <tilemesh/machine/buffer.hpp>
#include <tilemesh/machine/channel.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/superstep.hpp>
#include <tilemesh/splat/map/cast.hpp>
#include <tilemesh/splat/map/regions.hpp>
#include <tilemesh/splat/operations.hpp>

/// Records move to the tiles of their means in a new view, so that later views near it cost fewer messages. Where a record rests changes no
/// bit of a step. So a record that finds no way stays where it is: nothing must wait, and nothing can be lost.
namespace tilemesh { inline namespace v0_2 { namespace splat::map {

/// The tile to which each record wants to move.
struct Goals : Buffer<TileId> {
    static constexpr char const* name = "goals of records";
    static constexpr auto slots = &MapSizes::records;
};
/// A record on its way to its goal.
template <class Optimiser>
struct RecordMessage {
    Gaussian record;
    typename Optimiser::State state;
    TileId goal;
};
/// It lies in the memory of `Copies`: nothing is cast while records move. Its note offers the sender's room for records.
template <class Optimiser>
struct RestRoad : Channel<RecordMessage<Optimiser>> {
    static constexpr char const* name = "records on their way";
    static constexpr auto slots = &MapSizes::road;
    using memory_of = Copies;
};
/// What a pass of moving did.
struct RestPassed {
    static constexpr char const* name = "counters of a pass of moving";
    static constexpr bool per_pass = true;
    std::uint32_t looked, moved;
};
/// The operations of moving, for a cost model.
struct RestOperation {
    enum Kind : std::uint32_t {
        slot,        ///< a slot of a list that a kernel looks at
        moved_record ///< a record with its optimiser's words that is taken from a channel or given to one
    };
    static constexpr char const* names[] = {"slot", "moved_record"};
};
using RestOperations = tilemesh::Operations<RestOperation>;

/// Makes room for the goals.
struct BeginRest {
    static constexpr char const* name = "begin rest";
    void operator()(Records const& records, Goals& goals) const noexcept { goals.resize(records.size()); }
};
/// Finds the goal of each record on all workers: the tile of its mean; its own tile, if the view does not show it.
struct FindGoals {
    static constexpr char const* name = "find goals";
    void operator()(Here here, Broadcast<StepParameters> step, Records const& records, Goals& goals, Worker worker) const noexcept
    {
        for (std::uint32_t i = worker.index; i < records.size(); i += worker.count)
            goals[i] = goal_of(project(records[i], step->view, step->tiling), here.tile);
    }
    /// For a cost model, as `ProjectRecords`.
    static splat::Operations operations(Broadcast<StepParameters> step, Records const& records, Worker worker) noexcept
    {
        splat::Operations o;
        o[splat::Operation::projection] = projections_through(step->view.camera, (records.size() + worker.count - 1) / worker.count);
        return o;
    }
    /// A template, as `ProjectRecords::OnOneThread` is.
    template <class>
    struct OnOneThread {
        static constexpr char const* name = FindGoals::name;
        void operator()(Here here, Broadcast<StepParameters> step, Records const& records, Goals& goals, Worker) const noexcept
        {
            project_each(records, records.size(), *step, [&](std::uint32_t i, Splat const& s) { goals[i] = goal_of(s, here.tile); });
        }
    };
    using AllWorkers = OnOneThread<void>;

private:
    static TileId goal_of(Splat const& s, TileId here) noexcept { return s.visible() ? s.anchor : here; }
};
/// Begins the rounds, if a record of the tile has another goal.
struct StartRest {
    static constexpr char const* name = "start rest";
    Vote operator()(Here here, Goals const& goals) const noexcept
    {
        for (TileId const goal : goals)
            if (!(goal == here.tile)) return Vote::busy;
        return Vote::quiet;
    }
};
/// Stores the records that arrived, and offers a quarter of the free room to each side. So all that arrives finds room.
template <class Optimiser>
struct OfferRoom {
    static constexpr char const* name = "offer room";
    void operator()(Records& records, OptimiserStates<Optimiser>& states, Goals& goals, RestPassed& passed, In<RestRoad<Optimiser>> in,
                    Out<RestRoad<Optimiser>> out) const noexcept
    {
        for (Direction d : news)
            for (auto const& m : in[d]) {
                records.push(m.record);
                states.push(m.state);
                goals.push(m.goal);
                ++passed.moved;
            }
        std::uint32_t const room = records.room();
        for (Direction d : news) out[d].set_note(room / 4 + (index(d) < room % 4 ? 1 : 0));
    }
    /// For a cost model.
    static RestOperations operations(RestPassed const& passed) noexcept
    {
        RestOperations o;
        o[RestOperation::moved_record] = passed.moved;
        return o;
    }
};
/// Sends each record one tile nearer to its goal, if a tile there offered room: along its row, or else along its column. A round in which
/// no record moves is the last one. Each move shortens the way to a goal, so the rounds end, for any capacities.
template <class Optimiser>
struct MoveRecords {
    static constexpr char const* name = "move records";
    Vote operator()(Here here, Records& records, OptimiserStates<Optimiser>& states, Goals& goals, RestPassed& passed,
                    In<RestRoad<Optimiser>> in, Out<RestRoad<Optimiser>> out) const noexcept
    {
        for (std::uint32_t i = 0; i < records.size();) {
            ++passed.looked;
            if (!send(here.tile, records[i], states[i], goals[i], in, out)) {
                ++i;
                continue;
            }
            ++passed.moved;
            records.swap_remove(i);
            states.swap_remove(i);
            goals.swap_remove(i);
        }
        return passed.moved != 0 ? Vote::busy : Vote::quiet;
    }
    /// For a cost model.
    static RestOperations operations(RestPassed const& passed) noexcept
    {
        RestOperations o;
        o[RestOperation::slot] = passed.looked;
        o[RestOperation::moved_record] = passed.moved;
        return o;
    }

private:
    static bool send(TileId here, Gaussian const& g, typename Optimiser::State const& state, TileId goal, In<RestRoad<Optimiser>> const& in,
                     Out<RestRoad<Optimiser>>& out) noexcept
    {
        auto const to = [&](Direction d) noexcept { return out[d].size() < in[d].note() && out[d].try_push({g, state, goal}); };
        if (goal.x() > here.x() && to(Direction::east)) return true;
        if (goal.x() < here.x() && to(Direction::west)) return true;
        if (goal.y() > here.y() && to(Direction::south)) return true;
        return goal.y() < here.y() && to(Direction::north);
    }
};

/// Moves the records to the tiles of their means in a view. Cost: two supersteps a round, as many rounds as the farthest record has hops,
/// and more if tiles or channels fill.
template <class Optimiser>
using RestRecords = Sequence<Superstep<BeginRest>, Superstep<FindGoals>, Superstep<StartRest>,
                             Loop<Superstep<OfferRoom<Optimiser>>, Superstep<MoveRecords<Optimiser>>>>;

}}} // namespace tilemesh::splat::map
