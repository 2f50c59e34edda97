#pragma once
#include "team.hpp"
#include <atomic>
#include <cstdint>
#include <span>
#include <tilemesh/report/image.hpp>
#include <tilemesh/splat/blending.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/model.hpp>
#include <tilemesh/splat/policies.hpp>
#include <vector>

namespace bench {

namespace splat = tilemesh::splat;

/// Blends the splats `splats[rows[0]]` to `splats[rows[n - 1]]`, front to back, into the pixels of a tile, whose first one is `pixels`.
using BlendTile = splat::PairCount (*)(splat::PixelRect const& tile, splat::View const& view, std::uint32_t n,
                                       splat::Splat const* splats, std::uint32_t const* rows, splat::FloatPixel* pixels,
                                       std::uint32_t stride_px) noexcept;
/// As the machine does.
splat::PairCount blend_as_the_machine(splat::PixelRect const& tile, splat::View const& view, std::uint32_t n,
                                      splat::Splat const* splats, std::uint32_t const* rows, splat::FloatPixel* pixels,
                                      std::uint32_t stride_px) noexcept;

/// A bare rasteriser for shared memory: the mesh's kernels for projection and blending, and between them one sort of all splats by
/// depth and one list of splats for each tile of 32 x 20 pixels. No mesh, no copies, nothing kept from frame to frame. It is what the
/// machine's frame is measured against; its picture has the same bits.
class Direct {
public:
    struct Stages {
        double project = 0, sort = 0, bin = 0, blend = 0, total = 0; ///< milliseconds
    };

    /// Requires ids that differ. Keeps a copy of the records, in the order of their ids.
    explicit Direct(std::span<splat::Gaussian const> gaussians);

    /// Renders one frame on the team's threads.
    void render(splat::Camera const& camera, splat::Model const& model, Team& team,
                BlendTile blend_tile = blend_as_the_machine);

    /// Of the last frame.
    Stages const& stages() const noexcept { return stages_; }
    std::uint64_t pairs() const noexcept { return pairs_; }
    std::uint64_t pairs_contributing() const noexcept { return contributing_; }
    std::uint32_t visible() const noexcept { return visible_; }
    std::uint64_t entries() const noexcept { return list_.size(); } ///< of all tiles' lists
    /// Is the picture this one, bit for bit?
    bool equals(tilemesh::report::Image const& image) const noexcept;
    tilemesh::report::Image image() const;
    /// Bytes of host memory that it keeps.
    std::uint64_t bytes() const noexcept;

private:
    /// A visible splat on its way through the sort: depths are above 0, so that their bits are in their order.
    struct Key {
        std::uint32_t depth;
        std::uint32_t row;
    };
    /// The tiles that a splat touches: both ends inclusive.
    struct Range {
        std::uint16_t x0, x1, y0, y1;
    };
    /// What one thread does for itself.
    struct alignas(64) Share {
        std::vector<Key> keys, other;    ///< its records' keys, in order of depth once they are sorted; room to sort in
        std::vector<std::int32_t> count; ///< of its part of the sorted splats: list entries a tile
        std::vector<std::uint32_t> next; ///< where its next entry of each tile goes
        std::uint64_t blocks = 0, contributing = 0;
    };

    void project(std::uint32_t thread, std::uint32_t threads, splat::View const& view);
    static void sort(Share& share);
    void merge(std::uint32_t thread, std::uint32_t threads);
    void count(std::uint32_t thread, std::uint32_t threads);
    void place();
    void fill(std::uint32_t thread, std::uint32_t threads);
    void blend(std::uint32_t thread, splat::View const& view, BlendTile blend_tile, std::atomic<std::uint32_t>& next);

    std::vector<splat::Gaussian> gaussians_;
    std::vector<splat::Splat> splats_;
    std::vector<Range> ranges_;  ///< by row, of what is visible
    std::vector<Range> ordered_; ///< nearest first
    std::vector<Key> sorted_;
    std::vector<std::uint32_t> list_;  ///< rows, tile after tile, nearest first
    std::vector<std::uint32_t> begin_; ///< of each tile, and the end
    std::vector<Share> shares_;
    std::vector<splat::FloatPixel> pixels_;
    splat::Tiling tiling_{};
    std::uint32_t width_ = 0, height_ = 0, visible_ = 0;
    Stages stages_;
    std::uint64_t pairs_ = 0, contributing_ = 0;
};

} // namespace bench
