#pragma once
#include "options.hpp"

namespace track_bench {

/// Prints the tables of convergence that the options name, and writes them. Returns 1 if a bound is missed that must hold.
int basin(Options const& options);

} // namespace track_bench
