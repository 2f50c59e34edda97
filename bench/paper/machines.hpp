#pragma once
#include <common/machine.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/rules.hpp>
#include <tilemesh/splat/setup_types.hpp>

namespace paper {

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;

/// The paper's grid.
inline constexpr std::uint32_t grid_columns = 40, grid_rows = 36, tiles = grid_columns * grid_rows;

/// The report of a frame, with the modelled time of the library's kernels on Mk2 (model/cost_parameters.hpp, `mk2`).
struct ModelledFrame {
    report::FrameReport report;
    double milliseconds = 0;
};

/// The preset `lossless` on a Mk2 that keeps a trace. It renders frame after frame on one mesh.
class Watched {
public:
    struct Options {
        std::uint32_t threads = 1;
        std::uint32_t channel_slots = splat::Lossless::sizes.road;    ///< of road and beam
        std::uint32_t storage_slots = splat::Lossless::sizes.storage; ///< may be more than a tile of a Mk2 has
        std::optional<splat::Footprint> footprint{};
    };
    Watched(scene::Map const&, Options const&);
    ModelledFrame render(splat::Camera const&);

private:
    std::unique_ptr<bench::TracedMachine> machine_;
};

/// A cold start of the preset `paper`: records in the file's order, evenly over the tiles.
struct PaperFrame {
    report::Image image;
    report::FrameReport report;
    splat::Rules rules;
};
PaperFrame render_paper(scene::Map const&, splat::Camera const&, std::uint32_t channel_slots, std::uint32_t storage_slots,
                        std::uint32_t threads);

} // namespace paper
