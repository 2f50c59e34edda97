#pragma once
#include "options.hpp"

namespace track_bench {

/// Prints milliseconds of evaluations, of a frame, and of renders of the same map.
void times(Options const& options);
/// Prints the modelled milliseconds of evaluations on Mk2, step by step.
void modelled(Options const& options);

} // namespace track_bench
