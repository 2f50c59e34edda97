#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/model.hpp>

namespace paper {

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;

/// The paper's grid.
inline constexpr std::uint32_t grid_columns = 40, grid_rows = 36, tiles = grid_columns * grid_rows;

/// What a frame took, with the modelled time of our kernels on Mk2 (model/cost_parameters.hpp, `mk2`).
struct ModelledFrame {
    report::FrameReport report;
    double milliseconds = 0;
};

enum class Storage {
    preset, ///< 2,000 slots a tile
    roomy   ///< 20,000, which no tile of a Mk2 has
};

/// The preset `lossless` on a Mk2 that keeps a trace; frame after frame on one mesh.
class Watched {
public:
    struct Options {
        std::uint32_t threads = 1;
        std::uint32_t channel_slots = 200; ///< at most 400; the preset's
        Storage storage = Storage::preset;
        std::optional<splat::Footprint> footprint{};
    };
    virtual ~Watched() = default;
    virtual ModelledFrame render(splat::Camera const&) = 0;
};
std::unique_ptr<Watched> make_watched(scene::Map const&, Watched::Options);

/// A cold start of the preset `paper`: records in the file's order, evenly over the tiles.
struct PaperFrame {
    report::Image image;
    report::FrameReport report;
    splat::Model model;
};
PaperFrame render_paper(scene::Map const&, splat::Camera const&, std::uint32_t channel_slots, std::uint32_t storage_slots,
                        std::uint32_t threads);

} // namespace paper
