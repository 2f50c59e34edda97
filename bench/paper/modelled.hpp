#pragma once
#include "rows.hpp"
#include <cstdint>
#include <string>

namespace paper {

/// Frames of one scene on a machine that keeps a trace (machines.hpp): what our kernels would take on Mk2.
struct Modelled {
    std::uint64_t gaussians = 0;
    std::uint32_t frames = 0;
    double milliseconds = 0;    ///< of a frame, mean
    double least = 0, most = 0; ///< of one frame
    double first = 0;           ///< the cold start
    double static_view = 0;     ///< the same camera again
    bool complete = true;       ///< no frame lacks anything
};
/// The scene at 1280 x 720 from the benchmark camera, which then orbits by 0.5 degrees a frame, as the authors' recorded
/// benchmark does; a map without one from in front (`frame_whole`).
Modelled model_scene(Context const&, std::string const& scene);

} // namespace paper
