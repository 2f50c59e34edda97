#pragma once
#include "options.hpp"

namespace scaling {

/// Prints what arrays of Mk2 chips cost against one chip of as many tiles. Returns the exit status.
int chips(Options const& options);

} // namespace scaling
