#pragma once
#include "options.hpp"

namespace scaling {

/// Prints the predicted time of a frame over 1 to 1,024 hosts. Returns the exit status.
int predict(Options const& options);

} // namespace scaling
