#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/engine/not_quiet.hpp>
#include <tilemesh/error.hpp>

namespace tilemesh { inline namespace v0_2 {

TILEMESH_HOST std::string text_of(LoopCounters const& loop)
{
    auto const first = std::to_string(loop.first), last = std::to_string(loop.last);
    return first == last ? "the loop of step " + first : "the loop of steps " + first + " to " + last;
}

namespace engine {
TILEMESH_HOST Error GoesOn::error(std::string what) const
{
    what += ", and most_passes allows no more); allow more, or see what repeats";
    if (trace == nullptr) what += " on a Traced machine";
    else if (explain == nullptr) what += " (set explain to explain_no_progress)";
    what += " [superstep " + std::to_string(pass) + " (" + kernel + ")]";
    // Piece by piece: GCC 12 warns of a sum that begins with a literal (its bug 105651).
    if (trace != nullptr && explain != nullptr) what.append("\n").append(explain(*trace, grid, most_passes));
    if (what.back() == '\n') what.pop_back(); // the caller that prints the error ends the line
    return Error(what);
}
TILEMESH_HOST Error GoesOn::not_quiet(std::uint32_t step) const
{
    return error("step " + std::to_string(step) + " is not quiet after " + std::to_string(most_passes) +
                 " passes (tiles vote busy or have mail");
}
TILEMESH_HOST Error GoesOn::not_done(LoopCounters const& loop) const
{
    return error(text_of(loop) + " is not done after " + std::to_string(most_passes) + " rounds (tiles vote busy");
}
} // namespace engine

}} // namespace tilemesh
