#pragma once
#include <common/scenes.hpp>
#include <string>
#include <vector>

namespace channel_capacity {

using bench::Scene;

/// The delay of Gaussians whose anchor moved by `distance` tiles (along the row plus along the column), with `hops` hops per frame. A frame
/// is late if the record is not on its anchor tile at the end of the frame. 0: it was there in the frame that saw the new view.
struct LatencyRow {
    std::string scene;
    std::uint32_t hops = 0, distance = 0;
    std::uint64_t gaussians = 0;
    std::uint32_t late_min = 0, late_median = 0, late_max = 0;
    std::uint32_t expected = 0; ///< distance / hops, rounded down
};

struct Latency {
    std::vector<LatencyRow> rows;
    std::uint64_t copies = 0;         ///< pairs of a Gaussian and a tile that it touches, other than its anchor tile, in the new view
    std::uint64_t copies_on_time = 0; ///< copies that arrived exactly when `follow` expects a copy that had to be sent
    std::uint32_t frames_until_complete = 0;
    std::uint64_t refused = 0; ///< by a full channel; above 0 there is no expectation
};

/// Settles a machine on the scene's camera, jumps to the first camera of `motion`, and follows every Gaussian until all are on their tiles.
///
/// The expectation, if no channel is full: a record at distance d leaves in the first of its supersteps and is stored in superstep d + 1,
/// and a frame has `hops` supersteps. So it is floor(d / hops) frames late; with one hop per frame, exactly d. Bloom begins in the frame in
/// which the record arrives, with the same number of supersteps. So its copy on a tile that is b steps away on the tree is at most floor(b
/// / hops) frames later, and earlier if the tile had a copy already. `broken` gets a line for each distance at which a record differs, and
/// one line for all copies that are later.
Latency follow(Scene const& scene, std::string const& motion, std::uint32_t hops, std::filesystem::path const& data,
               std::vector<std::string>& broken);

} // namespace channel_capacity
