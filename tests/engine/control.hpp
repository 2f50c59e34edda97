#pragma once
#include "../standard.hpp"
#include <tilemesh/machine/reduce.hpp>
#include <tilemesh/machine/tile.hpp>

/// Programs of loops, conditions and reductions, and their results, computed on plain host arrays.
namespace engine_test {
using namespace tilemesh;

// --- a loop around an UntilQuiet: each round drains the water that the previous round refilled ---------------------------------
struct Tank {
    std::uint32_t level, refills, drained, rounds;
};
struct OpenTap {
    Vote operator()(Tank const& tank) const noexcept { return tank.level + tank.refills != 0 ? Vote::busy : Vote::quiet; }
};
struct Drain {
    Vote operator()(Tank& tank) const noexcept
    {
        if (tank.level == 0) return Vote::quiet;
        --tank.level;
        ++tank.drained;
        return tank.level != 0 ? Vote::busy : Vote::quiet;
    }
};
struct Refill {
    Vote operator()(Tank& tank) const noexcept
    {
        ++tank.rounds;
        if (tank.refills == 0) return Vote::quiet;
        tank.level += tank.refills--;
        return Vote::busy;
    }
};
using Draining = Sequence<Superstep<OpenTap>, Loop<UntilQuiet<Drain>, Superstep<Refill>>>;
using NestedDraining = Sequence<Superstep<OpenTap>, Loop<Loop<Superstep<Drain>>, Superstep<Refill>>>;

struct Drained {
    std::uint64_t rounds = 0, passes = 0;
    std::vector<Tank> tanks;
};
inline Drained drain_all(std::vector<Tank> tanks, std::uint32_t at_most)
{
    Drained d;
    auto const any = [&](auto const& f) { return std::any_of(tanks.begin(), tanks.end(), f); };
    bool busy = any([](Tank const& t) { return t.level + t.refills != 0; });
    for (; busy && d.rounds < at_most; ++d.rounds) {
        std::uint32_t deepest = busy ? 1 : 0; // a tile that voted busy runs once, with or without water
        for (auto& t : tanks) {
            deepest = std::max(deepest, t.level);
            t.drained += t.level;
            t.level = 0;
        }
        d.passes += deepest;
        busy = any([](Tank const& t) { return t.refills != 0; });
        for (auto& t : tanks) {
            ++t.rounds;
            if (t.refills != 0) t.level += t.refills--;
        }
    }
    d.tanks = std::move(tanks);
    return d;
}

// --- heat until no tile changes by more than a limit: a reduction ends a loop ------------------------------------------------------
struct Plate {
    float kelvin, change;
};
struct Settling {
    float per_step, limit;
    std::uint32_t cooled; ///< 0 or 1: an If reads it
};
struct Rim : Channel<float, 1> {};
struct Warm {
    Vote operator()(Plate const& plate, Out<Rim> out) const noexcept
    {
        for (auto d : news) out[d].push(plate.kelvin);
        return Vote::busy;
    }
};
struct Spread {
    void operator()(Plate& plate, Broadcast<Settling> k, In<Rim> in, Out<Rim> out) const noexcept
    {
        float flow = 0;
        for (auto d : news) flow += in[d][0] - plate.kelvin;
        plate.change = k->per_step * flow;
        plate.kelvin += plate.change;
        for (auto d : news) out[d].push(plate.kelvin);
    }
};
struct Cool {
    void operator()(Plate& plate, Here here) const noexcept
    {
        if (here.tile.x() == 0) plate.kelvin *= 0.875f;
    }
};
struct Change : Member<&Plate::change> {
    static constexpr char const* name = "change";
};
struct Judge {
    Vote operator()(Reduced<Change, Most> const& most, Broadcast<Settling> k) const noexcept
    {
        return most.value > k->limit ? Vote::busy : Vote::quiet;
    }
};
struct Forget {
    void operator()(In<Rim>) const noexcept {}
};
using Warming = Sequence<Superstep<Warm>,
                         Loop<Superstep<Spread>, If<&Settling::cooled, Superstep<Cool>>, Reduce<Change, Most, ReduceTo::all>, Superstep<Judge>>,
                         Superstep<Forget>>;

struct Settled {
    std::uint64_t rounds = 0;
    std::vector<Plate> plates;
};
inline Settled settle(std::vector<Plate> plates, Grid grid, Settling const& k, std::uint32_t at_most)
{
    Settled s;
    std::vector<float> told(plates.size()), before;
    for (std::size_t i = 0; i < plates.size(); ++i) told[i] = plates[i].kelvin;
    for (bool busy = true; busy && s.rounds < at_most; ++s.rounds) {
        before = told;
        for (std::uint32_t i = 0; i < grid.size(); ++i) {
            auto& p = plates[i];
            float flow = 0;
            for (auto d : news) flow += before[grid.index_of(grid.neighbour(grid.tile(i), d))] - p.kelvin;
            p.change = k.per_step * flow;
            p.kelvin += p.change;
            told[i] = p.kelvin;
            if (k.cooled != 0 && grid.tile(i).x() == 0) p.kelvin *= 0.875f;
        }
        busy = std::any_of(plates.begin(), plates.end(), [&](Plate const& p) { return p.change > k.limit; });
    }
    s.plates = std::move(plates);
    return s;
}

// --- conditions -------------------------------------------------------------------------------------------------------------------------
struct Wanted {
    std::uint32_t unused, first, second;
};
struct Tally {
    std::uint32_t sum;
};
template <std::uint32_t N>
struct Add {
    static constexpr char const* name = N == 1 ? "add one" : N == 10 ? "add ten" : "add hundred";
    void operator()(Tally& tally) const noexcept { tally.sum += N; }
};
using Choosing = Sequence<If<&Wanted::first, Superstep<Add<1>>, If<&Wanted::second, Superstep<Add<10>>>>, If<&Wanted::second>, Repeat<Add<100>>>;

// --- an argument and a step that a policy may leave out ---------------------------------------------------------------------------------
struct Log {
    std::uint32_t runs;
};
template <bool Logs>
struct Work {
    static constexpr char const* name = Logs ? "work and log" : "work";
    void operator()(Tally& tally, OnlyIf<Logs, Log&> log, OnlyIf<Logs, In<Rim>> in, Here here) const noexcept
    {
        tally.sum += here.tile.x();
        if constexpr (Logs) log.runs += 1 + in[Direction::west].size();
    }
};
struct Ring {
    void operator()(Out<Rim> out) const noexcept { out[Direction::east].push(1); }
};
template <bool Logs>
using Working = Sequence<StepIf<Logs, Superstep<Ring>>, Superstep<Work<Logs>>, StepIf<!Logs, Superstep<Add<100>>>>;

// --- reductions -------------------------------------------------------------------------------------------------------------------------
struct Load {
    float weight;
    std::uint32_t bits;
};
struct Weight : Member<&Load::weight> {
    static constexpr char const* name = "weight";
};
struct Bits : Member<&Load::bits> {
    static constexpr char const* name = "bits";
};
template <ReduceTo Where>
using Reducing = Sequence<Reduce<Weight, Sum, Where>, Reduce<Weight, Least, Where>, Reduce<Weight, Most, Where>, Reduce<Bits, And, Where>,
                          Reduce<Bits, Sum, Where>>;

struct Total {
    float sum, least, most;
    std::uint32_t all, bits;
};
/// Reduces each row from the east, then column 0 from the south: the order of Reduce.
template <class T, class F>
T reduce_on_host(std::vector<T> const& values, Grid grid, F const& f)
{
    std::vector<T> rows;
    for (std::uint32_t y = 0; y < grid.height; ++y) {
        T row = values[y * grid.width + grid.width - 1];
        for (std::uint32_t x = grid.width - 1; x-- > 0;) row = f(values[y * grid.width + x], row);
        rows.push_back(row);
    }
    T all = rows.back();
    for (std::uint32_t y = grid.height - 1; y-- > 0;) all = f(rows[y], all);
    return all;
}

} // namespace engine_test
