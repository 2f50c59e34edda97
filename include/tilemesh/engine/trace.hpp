#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/machine/superstep.hpp>
#include <type_traits>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// What one tile did in one superstep.
struct TileSample {
    std::uint32_t tile;              ///< index in the grid
    OperationCounts operations;      ///< of the kinds that Trace::operations names for the step
    std::uint32_t sent_bytes[4];     ///< of messages and their heads, towards each side (news); 0 where nothing went
    friend bool operator==(TileSample const&, TileSample const&) = default;
};

/// One superstep: the tiles that ran, in order, and what the exchange moved.
struct SuperstepSample {
    std::uint32_t step;              ///< of the program
    bool votes;                      ///< tiles vote whether there is another, or another round: of UntilQuiet, or of the last step of a Loop
    std::uint32_t capacity_bytes;    ///< that a compile-time exchange moves from each tile to each neighbour; 0: no channel
    bool sent;                       ///< anything
    std::vector<TileSample> tiles;
    friend bool operator==(SuperstepSample const&, SuperstepSample const&) = default;
};

/// A run, superstep by superstep: what a cost model (model/cost_model.hpp) and the trace files are made of. The same on every
/// engine and any number of threads. Host memory: 56 bytes a tile that runs in a superstep.
struct Trace {
    std::vector<std::string> kernels; ///< of the program's steps
    /// For each step the names of the operations that its kernel counts, in the order of OperationCounts; empty for a kernel that counts
    /// none.
    std::vector<std::vector<std::string>> operations;
    std::vector<SuperstepSample> supersteps;
    std::vector<LoopCounters> loops = {}; ///< of the program, and their rounds
    friend bool operator==(Trace const&, Trace const&) = default;
};

namespace engine {
/// What stands for a trace where none is kept.
struct NoTrace {};

/// The names of the operations that the kernels of a program's steps count, in program order.
template <class... Step>
void list_operations(Types<Step...>, std::vector<std::vector<std::string>>& out)
{
    [[maybe_unused]] auto const add = [&](auto names) { out.emplace_back(names.begin, names.begin + names.size); };
    (add(operation_names<KernelOf<Step>>()), ...);
}
/// The empty trace of a run that has not begun.
template <class Program>
Trace begin_trace(RunCounters const& run)
{
    Trace trace;
    for (auto const& s : run.steps) trace.kernels.push_back(s.kernel);
    list_operations(StepsOf<Program>{}, trace.operations);
    trace.loops = run.loops;
    return trace;
}

/// Adds the bytes that the tile of `source` sent on a channel; does nothing for other parameters of a kernel.
template <class X, class Source>
void add_sent(TileSample&, Source&, X*) noexcept
{
}
template <class C, class Source>
void add_sent(TileSample& s, Source& source, Out<C>*) noexcept
{
    for (Direction d : news) {
        auto const* const head = source.template out<C>(d).head;
        if ((head[0] | head[1]) != 0) s.sent_bytes[index(d)] += source.template end_bytes<C>(head[0]);
    }
}
template <class Source, class... A>
void add_all_sent(TileSample& s, [[maybe_unused]] Source& source, Types<A...>) noexcept
{
    (add_sent(s, source, static_cast<std::remove_cv_t<std::remove_reference_t<A>>*>(nullptr)), ...);
}
/// What kernel K's run on the tile of `source` did; before its mail is forgotten.
template <class K, class Source>
TileSample sample(Source& source, std::uint32_t tile) noexcept
{
    TileSample s{tile, operations_of<K>(source), {0, 0, 0, 0}};
    add_all_sent(s, source, typename KernelTraits<K>::Arguments{});
    return s;
}
} // namespace engine

}} // namespace tilemesh
