#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>

namespace tilemesh { inline namespace v0_2 {

/// A function that explains in a few lines why a run made no progress; `most_passes` is the bound that stopped the run. An engine
/// appends the text to its error. `explain_no_progress` of model/no_progress.hpp is such a function.
using ExplainNotQuiet = std::string (*)(Trace const& trace, Grid grid, std::uint32_t most_passes);

/// The name of a loop in errors: "the loop of steps 1 to 3".
TILEMESH_HOST std::string text_of(LoopCounters const& loop);

namespace engine {
/// Makes an engine's error for a step or a loop that never ends. `trace` is null on a machine without one. `explain` may be null; it is
/// called only if there is a trace.
struct GoesOn {
    std::string const& kernel;
    std::uint64_t pass;
    std::uint32_t most_passes;
    Trace const* trace;
    Grid grid;
    ExplainNotQuiet explain;

    /// `what` is the beginning of the error: "step 1 is not quiet after 5 passes (tiles vote busy".
    Error error(std::string what) const;
    Error not_quiet(std::uint32_t step) const;
    Error not_done(LoopCounters const& loop) const;
};
} // namespace engine

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/engine/detail/not_quiet_code.hpp>
#endif
