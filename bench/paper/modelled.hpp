#pragma once
#include "rows.hpp"
#include <cstdint>
#include <string>

namespace paper {

/// Frames of one scene on a machine that keeps a trace (machines.hpp): the modelled time of the library's kernels on Mk2.
struct Modelled {
    std::uint64_t gaussians = 0;
    std::uint32_t frames = 0;
    double milliseconds = 0;    ///< per frame, mean
    double least = 0, most = 0; ///< of a single frame
    double first = 0;           ///< the cold start
    double static_view = 0;     ///< the same camera again
    bool complete = true;       ///< no frame lacks records or copies
};
/// Models the scene at 1280 x 720. The camera is the benchmark camera and orbits by 0.5 degrees per frame, as in the authors' recorded
/// benchmark. For a map without a benchmark camera, it is `frame_whole`.
Modelled model_scene(Context const&, std::string const& scene);

} // namespace paper
