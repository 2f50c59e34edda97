#pragma once
#include "explain.hpp"
#include "options.hpp"
#include "shots.hpp"
#include <cstdint>
#include <string>
#include <vector>

namespace render_map {

/// Refuses what would fill the host's memory, and frames that the default grid of the chosen machine has no framebuffers for,
/// before a tile is built: throws `tilemesh::Error` that says what to type instead.
void check_sizes(Options const& options, std::vector<Shot> const& shots);

/// Refuses --channel-slots and --storage-slots outside the range of the machine that the run takes. The error says how the range comes
/// about and what has more room.
void check_slots(Options const& options, Needs const& needs);

/// What has room for `slots` records on every tile, for example "--machine test (40,000 slots a tile)"; empty: nothing has.
std::string roomier(Options const& options, Needs const& needs, std::uint64_t slots);

} // namespace render_map
