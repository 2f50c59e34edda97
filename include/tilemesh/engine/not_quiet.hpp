#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 {

/// A function that explains in a few lines why a run made no progress; `most_passes` is the bound that stopped the run. An engine
/// appends the text to its error. `explain_no_progress` of model/no_progress.hpp is such a function.
using ExplainNotQuiet = std::string (*)(Trace const& trace, Grid grid, std::uint32_t most_passes);

/// The name of a loop in errors: "the loop of steps 1 to 3".
inline std::string text_of(LoopCounters const& loop)
{
    auto const first = std::to_string(loop.first), last = std::to_string(loop.last);
    return first == last ? "the loop of step " + first : "the loop of steps " + first + " to " + last;
}

namespace engine {
/// Makes an engine's error for a step or a loop that never ends. `trace` is a Trace or NoTrace. `explain` may be null; it is called only
/// if there is a trace.
template <class MaybeTrace>
struct GoesOn {
    std::string const& kernel;
    std::uint64_t pass;
    std::uint32_t most_passes;
    MaybeTrace const& trace;
    Grid grid;
    ExplainNotQuiet explain;

    /// `what` is the beginning of the error: "step 1 is not quiet after 5 passes (tiles vote busy".
    Error error(std::string what) const
    {
        constexpr bool traced = std::is_same_v<MaybeTrace, Trace>;
        what += ", and most_passes allows no more); allow more, or see what repeats";
        if constexpr (!traced) what += " on a Traced machine";
        else if (explain == nullptr) what += " (set explain to explain_no_progress)";
        what += " [superstep " + std::to_string(pass) + " (" + kernel + ")]";
        if constexpr (traced)
            if (explain != nullptr) what += "\n" + explain(trace, grid, most_passes);
        if (what.back() == '\n') what.pop_back(); // the caller that prints the error ends the line
        return Error(what);
    }
    Error not_quiet(std::uint32_t step) const
    {
        return error("step " + std::to_string(step) + " is not quiet after " + std::to_string(most_passes) +
                     " passes (tiles vote busy or have mail");
    }
    Error not_done(LoopCounters const& loop) const
    {
        return error(text_of(loop) + " is not done after " + std::to_string(most_passes) + " rounds (tiles vote busy");
    }
};
} // namespace engine

}} // namespace tilemesh
