#pragma once
#include <cstdint>
#include <cstddef>
#include <memory>
#include <span>
#include <tilemesh/config.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/splat/map/sums.hpp>
#include <tilemesh/splat/map/tile.hpp>
#include <tilemesh/splat/target_pixel.hpp>
#include <tilemesh/splat/view.hpp>
#include <vector>

/// What a picture of the map says against a target, on the host: the loss, and the sums of each splat. It runs the kernels of splat/map/
/// tile by tile.
namespace tilemesh { inline namespace v0_2 { namespace mapping {

/// A picture that the camera saw: linear RGB; view depth in world units, 0 where it is not known. A pixel with a colour that is NaN does
/// not count.
struct Target {
    std::uint32_t width = 0, height = 0;
    std::vector<splat::TargetPixel> pixels; ///< row by row

    bool empty() const noexcept { return pixels.empty(); }
};
/// A target from a picture and, if it is not empty, the depths of the picture's size. Throws `Error` for another size.
Target make_target(report::Image const& colour, report::Plane const& depth = {});

/// How well a picture agrees with its target.
struct Fit {
    double loss = 0;          ///< by the rules of the loss, summed over pixels
    double squares = 0;       ///< of the differences of colours, over pixels and channels, not clamped
    std::uint64_t pixels = 0; ///< that count

    /// Peak signal-to-noise ratio for colours of 0 to 1; infinite for equal pictures.
    double psnr_db() const noexcept;
};
/// A picture as blending gave it: colour on the background, depth (0 where splats cover at most half of the pixel), and the share of each
/// pixel that splats cover.
struct Seen {
    report::Image colour;
    report::Plane depth, cover;
};

/// How a frame is cut and computed. The sums have the same bits for any tile of whole blocks (`splat::map::has_whole_blocks`) and any
/// number of threads.
struct ViewOptions {
    splat::TileSize tile{32, 20};
    std::uint32_t threads = 1;
    splat::map::LossRules loss{1, 0, 0, 0, 4};
};

/// The loss of views against targets, and the sums of each splat.
///
/// The records' splats come from the caller, one a record; invisible ones are left out. Splats are sorted by depth, then by id. Throws
/// `Error` for a tile that cuts blocks, no thread, a limit or weight that is not positive and finite, and a target of another size than
/// the camera's.
///
/// Cost: a step of 640 x 480 pixels takes about 3.5 times as long as the blending of the picture (bench/mapping). Memory: 56 bytes a
/// visible splat, 4 a splat and tile, 40 a record, and about 100 KiB a thread.
class ViewSums {
public:
    explicit ViewSums(ViewOptions const& options);
    ~ViewSums();
    ViewSums(ViewSums&&) noexcept;
    ViewSums& operator=(ViewSums&&) noexcept;

    /// The loss alone; `seen`, if it is not null, gets the picture.
    Fit measure(std::span<splat::Splat const> splats, std::span<splat::Gaussian const> records, splat::View const& view,
                Target const& target, Seen* seen = nullptr);
    /// The loss, and the sums of each record's splat in `sums`.
    Fit add_up(std::span<splat::Splat const> splats, std::span<splat::Gaussian const> records, splat::View const& view,
               Target const& target);
    std::span<splat::map::SplatSums const> sums() const noexcept { return sums_; }

    ViewOptions const& options() const noexcept { return options_; }

private:
    struct Workspace;
    static void show(splat::map::BlendedBlock const& block, float const (&background)[3], Seen& to) noexcept;
    Fit run(std::span<splat::Splat const> splats, std::span<splat::Gaussian const> records, splat::View const& view,
            Target const& target, bool with_sums, Seen* seen);
    void sort(std::span<splat::Splat const> splats, std::span<splat::Gaussian const> records);
    void bin(splat::Tiling const& tiling);

    ViewOptions options_;
    std::vector<splat::map::SplatSums> sums_;
    std::vector<std::uint64_t> keys_, other_keys_;      ///< depth, then id
    std::vector<std::uint32_t> rows_, other_rows_;      ///< the record of each key
    std::vector<splat::Splat> sorted_;
    std::vector<std::uint32_t> begin_, listed_;         ///< of each tile: its splats among `sorted_`
    std::vector<splat::map::BlockLoss> losses_;         ///< of each block of the frame
    std::vector<std::unique_ptr<Workspace>> workspaces_;
};

}}} // namespace tilemesh::mapping

#include <tilemesh/mapping/detail/view_sums_code.hpp>
