#pragma once
#include "options.hpp"
#include "shots.hpp"
#include <vector>

namespace render_map {

/// Refuses what would fill the host's memory, and frames that the default grid of the chosen machine has no framebuffers for,
/// before a tile is built: throws `tilemesh::Error` that says what to type instead.
void check_sizes(Options const& options, std::vector<Shot> const& shots);

} // namespace render_map
