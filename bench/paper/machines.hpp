#pragma once
#include "tables.hpp"
#include <common/machine.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tilemesh/splat/setup_types.hpp>

namespace paper {

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;

/// The paper's grid.
inline constexpr std::uint32_t grid_columns = 40, grid_rows = 36, tiles = grid_columns * grid_rows;

/// The preset `lossless` on a Mk2 that keeps a trace.
struct Watched {
    std::uint32_t threads = 1;
    std::uint32_t channel_slots = splat::Lossless::sizes.road;    ///< of road and beam
    std::uint32_t storage_slots = splat::Lossless::sizes.storage; ///< may be more than a tile of a Mk2 has
    std::optional<splat::Footprint> footprint{};
};
std::unique_ptr<bench::Machine> make_watched(scene::Map const&, Watched const&);

/// A cold start of the preset `paper`: records in the file's order, evenly over the tiles.
struct PaperFrame {
    report::Image image;
    report::FrameReport report;
    splat::Rules rules;
};
PaperFrame render_paper(scene::Map const&, splat::Camera const&, std::uint32_t channel_slots, std::uint32_t storage_slots, std::uint32_t threads);

/// Frames of one scene: the modelled time of the library's kernels on Mk2.
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
