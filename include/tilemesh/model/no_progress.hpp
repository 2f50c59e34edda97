#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/grid.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// One side of a tile.
struct TileSide {
    std::uint32_t tile;
    Direction side;
    friend bool operator==(TileSide const&, TileSide const&) = default;
};
/// The use of one side of a tile in a period.
struct TileSideUse {
    TileSide link;
    std::uint32_t supersteps; ///< number of supersteps in which the link carried something
    std::uint64_t bytes;      ///< bytes of messages, notes and heads
    bool notes_only;          ///< no superstep carried more than one head: a note and no message
    bool full;                ///< every slot was full in each of these supersteps; more messages may have waited
    friend bool operator==(TileSideUse const&, TileSideUse const&) = default;
};

/// The part of a trace's end that an UntilQuiet or a Loop repeats.
struct NoProgress {
    Grid grid;
    std::uint32_t step = 0;               ///< the step that repeats; for a Loop, the step that ran last
    std::string kernel;
    std::optional<LoopCounters> loop;     ///< the innermost Loop that repeats, if the step alone does not
    std::uint64_t supersteps = 0;         ///< supersteps of the step or Loop at the end of the trace; 0: the trace ends with another kind of step
    std::uint32_t period = 0;             ///< length in supersteps; 0: nothing repeats, and the members below are empty
    std::uint64_t first = 0;              ///< the superstep of the run from which the trace repeats
    std::vector<std::uint32_t> tiles;     ///< tiles that run in every superstep
    std::vector<TileSideUse> links;           ///< sides that carry something, in the order of tiles and sides
    std::vector<TileSide> cycle;              ///< sides around which messages go: each leads to the tile of the next, the last to the first
    std::vector<std::uint32_t> waiting;   ///< tiles that run in every superstep and send no message: busy, or woken by mail
    /// The sides to which each waiting tile sent its last messages in the run; none if it has sent none. The tile may wait for such a side.
    std::vector<TileSide> sent_last;
    /// A closed walk along these sides, among waiting tiles. It is a guess that each tile waits for the next; it may wait for another tile.
    std::vector<TileSide> wait_cycle;
    std::uint64_t settled_bytes = 0;      ///< settled bytes of a period, of kernels that count them
    bool empty() const noexcept { return period == 0; }
};

/// The longest period that the search tries. A walk around a grid of 1,000 x 850 tiles takes 3,696 supersteps.
inline constexpr std::uint32_t most_period = 4096;

namespace model_detail {
/// The number of supersteps that must repeat for a report, unless the caller accepts fewer: two equal supersteps prove nothing.
inline constexpr std::uint32_t repeated_at_least = 16;

} // namespace model_detail

/// Searches the end of a trace for an UntilQuiet that never becomes quiet, or a Loop that never ends: the same tiles do the same work and
/// send equal messages again and again. At least `at_least` supersteps must repeat, and a period at least twice. `at_least` is at least
/// two.
///
/// Two supersteps are equal if a trace shows no difference: the tiles that ran, the operations that kernels count, and the bytes sent. So a
/// steady stream from a sending tile to a receiving tile also looks like a repetition, unless the kernel counts something that grows (Route
/// and Bloom count the slots that they look at). The report names waiting tiles. A trace holds sent bytes but no refusals, so it does not
/// show for which tile they wait. The sides to which they sent last are a guess; it fits channels and credits that filled up. Throws
/// `Error` for a trace of another grid. Cost: linear in the trace, except for a trace that almost repeats, and 30 bytes a tile.
TILEMESH_HOST NoProgress no_progress(Trace const& trace, Grid grid, std::uint32_t at_least = model_detail::repeated_at_least);

/// The report in a few lines, each with a line end. Of each list it names at most `most` items.
TILEMESH_HOST std::string text_of(NoProgress const& report, std::size_t most = 16);

/// Reports the repetition at the end of a run that `most_passes` stopped. With MeshOptions::explain = explain_no_progress, the error of a
/// run on a Traced machine ends with this report.
TILEMESH_HOST std::string explain_no_progress(Trace const& trace, Grid grid, std::uint32_t most_passes);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/no_progress_code.hpp>
#endif
