#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <type_traits>

namespace tilemesh {

/// Says in a few lines why a run made no progress; `most_passes` is the bound that stopped it. An engine appends the text to its
/// error. `explain_no_progress` of model/no_progress.hpp is one.
using ExplainNotQuiet = std::string (*)(Trace const& trace, Grid grid, std::uint32_t most_passes);

namespace engine::detail {
/// What an engine throws where a step of UntilQuiet has run more passes than it may; `trace` is a Trace or NoTrace. `explain` may
/// be null, and is called only where there is a trace.
template <class MaybeTrace>
Error not_quiet(StepCounters const& counters, std::uint32_t step, std::uint64_t pass, std::uint32_t most_passes,
                [[maybe_unused]] MaybeTrace const& trace, [[maybe_unused]] Grid grid, [[maybe_unused]] ExplainNotQuiet explain)
{
    std::string text = "step " + std::to_string(step) + " is not quiet after " + std::to_string(most_passes) +
                       " passes (tiles vote busy or have mail, and most_passes allows no more); allow more, or see what repeats";
    constexpr bool traced = std::is_same_v<MaybeTrace, Trace>;
    if constexpr (!traced) text += " on a Traced machine";
    else if (explain == nullptr) text += " (set explain to explain_no_progress)";
    text += " [superstep " + std::to_string(pass) + " (" + counters.kernel + ")]";
    if constexpr (traced)
        if (explain != nullptr) text += "\n" + explain(trace, grid, most_passes);
    if (text.back() == '\n') text.pop_back(); // who prints an error ends its line
    return Error(text);
}
} // namespace engine::detail

} // namespace tilemesh
