#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/machine/superstep.hpp>
#include <type_traits>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// The work of one tile in one superstep.
struct TileSample {
    std::uint32_t tile;              ///< index in the grid
    OperationCounts operations;      ///< counts of the operations that Trace::operations names for the step
    std::uint32_t sent_bytes[4];     ///< bytes of messages and their heads, to the neighbour on each side (news); 0 if nothing went there
    friend bool operator==(TileSample const&, TileSample const&) = default;
};

/// One superstep: the tiles that ran, in order, and what the exchange moved.
struct SuperstepSample {
    std::uint32_t step;              ///< number of the step in the program
    bool votes;                      ///< do tiles vote on another superstep or round? True for UntilQuiet and for the last step of a Loop
    /// bytes that a compile-time exchange moves from each tile to a neighbour, if all channels have that side; 0: no channel
    std::uint32_t capacity_bytes;
    bool sent;                       ///< did the exchange move a message or a note?
    std::vector<TileSample> tiles;
    Edge edge = Edge::reflect;       ///< of the channels that the kernel sends on; `reflect` if they differ
    std::array<std::uint32_t, 4> absent_bytes{}; ///< of capacity_bytes, those of channels without this side (news)

    /// The bytes that a compile-time exchange moves from each tile towards d; from each tile in all.
    std::uint32_t capacity_towards(Direction d) const noexcept { return capacity_bytes - absent_bytes[index(d)]; }
    std::uint64_t capacity_of_tile() const noexcept
    {
        std::uint64_t bytes = 0;
        for (Direction d : news) bytes += capacity_towards(d);
        return bytes;
    }
    friend bool operator==(SuperstepSample const&, SuperstepSample const&) = default;
};

/// A run, superstep by superstep. Cost models (model/cost_model.hpp) and trace files are made from it. It is equal on every engine and with
/// any number of threads. Host memory: 56 bytes for each tile that runs in a superstep.
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
/// Replaces a trace if none is kept.
struct NoTrace {};

/// The trace of a frame whose program ran once or several times: that of the mesh, or the runs one behind the other. It copies nothing
/// unless there is a second run.
class JoinedTrace {
public:
    Trace const& of(Trace const& of_mesh) const noexcept { return runs_ == 1 ? of_mesh : joined_; }
    /// Begins a frame. `last`: the mesh's trace, of which the names of kernels stay.
    void begin(Trace const* last)
    {
        joined_.supersteps.clear();
        if (last != nullptr && joined_.kernels.empty()) {
            joined_.kernels = last->kernels;
            joined_.operations = last->operations;
            joined_.loops = last->loops;
        }
        for (auto& loop : joined_.loops) loop.rounds = 0;
        runs_ = 0;
    }
    /// Call it before each run of the mesh, and `after` behind it.
    void before(Trace const& of_mesh)
    {
        if (runs_ == 1) joined_ = of_mesh;
    }
    void after(Trace const& of_mesh)
    {
        if (++runs_ == 1) return;
        joined_.supersteps.insert(joined_.supersteps.end(), of_mesh.supersteps.begin(), of_mesh.supersteps.end());
        for (std::size_t i = 0; i < joined_.loops.size(); ++i) joined_.loops[i].rounds += of_mesh.loops[i].rounds;
    }

private:
    Trace joined_;
    std::uint32_t runs_ = 0;
};

/// Adds the bytes that the tile of `source` sent on a channel, without what an edge drops; does nothing for other parameters of a kernel.
template <class X, class Source>
void add_sent(TileSample&, Source&, X*) noexcept
{
}
template <class C, class Source>
void add_sent(TileSample& s, Source& source, Out<C>*) noexcept
{
    for (Direction d : news) {
        if constexpr (C::sends_to != Sides::all)
            if (!contains(C::sends_to, d)) continue;
        if constexpr (C::edge == Edge::drop)
            if (Here const here = source.here(); !here.grid.has_neighbour(here.tile, d)) continue;
        auto const* const head = source.template out<C>(d).head;
        if ((head[0] | head[1]) != 0) s.sent_bytes[index(d)] += source.template end_bytes<C>(head[0]);
    }
}
template <class Source, class... A>
void add_all_sent(TileSample& s, [[maybe_unused]] Source& source, machine::Types<A...>) noexcept
{
    (add_sent(s, source, static_cast<std::remove_cv_t<std::remove_reference_t<A>>*>(nullptr)), ...);
}
/// The work of kernel K's last run on the tile of `source`. Call it before the tile's mail is forgotten.
template <class K, class Source>
TileSample sample(Source& source, std::uint32_t tile) noexcept
{
    TileSample s{tile, operations_of<K>(source), {0, 0, 0, 0}};
    add_all_sent(s, source, typename KernelTraits<K>::Arguments{});
    return s;
}
} // namespace engine

}} // namespace tilemesh
