#pragma once
#include "options.hpp"

namespace any_map {

/// Writes the picture of the first page: a part of playbot_250k, on anchored tiles, which lack records, and with homes. Throws Error
/// if the map is not there.
void write_picture(Options const& options);

} // namespace any_map
