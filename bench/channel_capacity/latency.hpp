#pragma once
#include <common/scenes.hpp>
#include <string>
#include <vector>

namespace channel_capacity {

using bench::Scene;

/// How late Gaussians are whose anchor moved `distance` tiles (along the row plus along the column), where a frame has `hops` hops.
/// A frame is late when the record is not on its anchor tile at its end; 0: it was there in the frame that saw the new view.
struct LatencyRow {
    std::string scene;
    std::uint32_t hops = 0, distance = 0;
    std::uint64_t gaussians = 0;
    std::uint32_t late_min = 0, late_median = 0, late_max = 0;
    std::uint32_t expected = 0; ///< distance / hops, rounded down
};

struct Latency {
    std::vector<LatencyRow> rows;
    std::uint64_t copies = 0;         ///< pairs of a Gaussian and a tile that it touches beside its anchor tile, in the new view
    std::uint64_t copies_on_time = 0; ///< that were there after exactly what `follow` expects of a copy that had to be sent
    std::uint32_t frames_until_complete = 0;
    std::uint64_t refused = 0; ///< by a full channel: above 0 nothing is expected
};

/// Settles a machine on the scene's camera, jumps to the first camera of `motion`, and follows every Gaussian until all are home.
///
/// What is expected, where no channel is full. A record at distance d leaves in the first of its supersteps and is stored in superstep
/// d + 1, and a frame has `hops` of them: it is late floor(d / hops) frames, so with one hop a frame exactly d. In the frame in which
/// it comes home bloom begins, with as many supersteps: its copy on a tile that is b steps away on the tree is at most floor(b / hops)
/// frames later, and earlier where a copy was there already. `broken` gets a line for each distance at which one record is not so, and
/// one for all copies that are later.
Latency follow(Scene const& scene, std::string const& motion, std::uint32_t hops, std::filesystem::path const& data,
               std::vector<std::string>& broken);

} // namespace channel_capacity
