#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <vector>

namespace tilemesh {

/// How the exchange is paid for.
enum class ExchangeCost : std::uint32_t {
    capacity,   ///< every slot of every channel that the superstep sends on, live or not: Poplar's compile-time copies
    live        ///< what was sent
};

/// A number that a model needs, with where it is from.
struct Parameter {
    std::string name;
    std::uint64_t value;
    std::string unit;
    std::string source; ///< a document, or "fitted to ..."
    friend bool operator==(Parameter const&, Parameter const&) = default;
};

/// The largest numbers of a model, for exact sums in 64 bits. Seven kinds of 2^32 - 1 operations at 100,000 cycles each are 3.0e18
/// millicycles, four ends of 2^32 - 1 bytes 1.7e18, and 64 bits hold 1.8e19. 1e12 cycles are a quarter of an hour at 1 GHz.
inline constexpr std::uint64_t most_millicycles = 100'000'000, most_cycles = 1'000'000'000'000, most_clock_khz = 1'000'000'000;

/// What a machine's cycles go to. All integers: modelled cycles are exact and the same everywhere.
///
/// A superstep costs the slowest tile's compute, the exchange, a sync, and the vote where there is one:
///   compute   run + sum over operations of count * cycles / 1,000, rounded up; of the slowest tile
///   exchange  exchange + bytes that the busiest tile receives * exchange_byte / 1,000, rounded up; 0 where the superstep has no
///             channel, or (`live`) nothing was sent
///   sync      sync
///   vote      vote, in supersteps of UntilQuiet
struct CostModel {
    std::string name;
    std::uint64_t clock_khz = 1'325'000;
    ExchangeCost exchange_cost = ExchangeCost::capacity;
    std::array<std::uint64_t, operation_kinds> millicycles{}; ///< of a tile, 1/1,000 cycle an operation
    std::uint64_t run_cycles = 0;                             ///< to enter and leave a vertex
    std::uint64_t exchange_cycles = 0, sync_cycles = 0, vote_cycles = 0;
    std::uint64_t exchange_millicycles_a_byte = 0;
    std::vector<Parameter> parameters;                        ///< where the numbers are from, for reports
    friend bool operator==(CostModel const&, CostModel const&) = default;
};

/// Modelled cycles of a superstep.
struct SuperstepCost {
    std::uint32_t step;
    std::uint64_t compute = 0, exchange = 0, sync = 0, vote = 0;
    std::uint32_t slowest = 0; ///< the tile
    std::uint64_t total() const noexcept { return compute + exchange + sync + vote; }
};

/// Modelled cycles of a run.
struct RunCost {
    std::vector<SuperstepCost> supersteps;
    std::vector<std::vector<std::uint64_t>> busy; ///< of each step of the program, for each tile: cycles it computes
    std::uint64_t cycles = 0;
};

namespace model_detail {
constexpr std::uint64_t per_thousand(std::uint64_t count, std::uint64_t millicycles) noexcept
{
    return (count * millicycles + 999) / 1000;
}
inline std::uint64_t compute_cycles(CostModel const& m, Operations const& o) noexcept
{
    std::uint64_t millicycles = 0;
    for (std::uint32_t i = 0; i < operation_kinds; ++i) millicycles += o.count[i] * m.millicycles[i];
    return m.run_cycles + (millicycles + 999) / 1000;
}
/// Refuses numbers with which a superstep's sums could pass 64 bits.
inline void expect_sums_fit(CostModel const& m)
{
    std::uint64_t millicycles = m.exchange_millicycles_a_byte, cycles = 0;
    for (auto n : m.millicycles) millicycles = std::max(millicycles, n);
    for (auto n : {m.run_cycles, m.exchange_cycles, m.sync_cycles, m.vote_cycles}) cycles = std::max(cycles, n);
    if (millicycles > most_millicycles || cycles > most_cycles)
        throw Error("a cost model cannot be applied (" +
                    (millicycles > most_millicycles
                         ? std::to_string(millicycles) + " millicycles exceed " + std::to_string(most_millicycles)
                         : std::to_string(cycles) + " cycles exceed " + std::to_string(most_cycles)) +
                    "); give it smaller numbers");
}
} // namespace model_detail

/// Applies a model to a trace; as often as one likes, with any model. Throws `Error` where a number of the model is above its
/// limit, and where the run's cycles pass 64 bits. Cost: linear in the trace.
inline RunCost model_cost(CostModel const& m, Trace const& trace, Grid grid)
{
    model_detail::expect_sums_fit(m);
    RunCost out;
    out.busy.assign(trace.kernels.size(), std::vector<std::uint64_t>(grid.size(), 0));
    std::vector<std::uint64_t> received(grid.size());
    for (auto const& s : trace.supersteps) {
        SuperstepCost c{s.step};
        for (auto const& t : s.tiles) {
            auto const cycles = model_detail::compute_cycles(m, t.operations);
            out.busy[s.step][t.tile] += cycles;
            if (cycles > c.compute) {
                c.compute = cycles;
                c.slowest = t.tile;
            }
        }
        if (m.exchange_cost == ExchangeCost::capacity) {
            if (s.capacity_bytes != 0)
                c.exchange = m.exchange_cycles + model_detail::per_thousand(std::uint64_t{4} * s.capacity_bytes, m.exchange_millicycles_a_byte);
        } else if (s.sent) {
            std::fill(received.begin(), received.end(), 0);
            for (auto const& t : s.tiles)
                for (Direction d : news) received[grid.index_of(grid.neighbour(grid.tile(t.tile), d))] += t.sent_bytes[index(d)];
            c.exchange = m.exchange_cycles +
                         model_detail::per_thousand(*std::max_element(received.begin(), received.end()), m.exchange_millicycles_a_byte);
        }
        c.sync = m.sync_cycles;
        c.vote = s.votes ? m.vote_cycles : 0;
        if (c.total() > std::numeric_limits<std::uint64_t>::max() - out.cycles)
            throw Error("a run cannot be modelled (its cycles pass 64 bits after " + std::to_string(out.supersteps.size()) +
                        " supersteps); give the cost model smaller numbers");
        out.cycles += c.total();
        out.supersteps.push_back(c);
    }
    return out;
}

inline double milliseconds(CostModel const& m, std::uint64_t cycles) noexcept
{
    return static_cast<double>(cycles) / static_cast<double>(m.clock_khz);
}

} // namespace tilemesh
