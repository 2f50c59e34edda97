#pragma once
#include "team.hpp"
#include <cstdint>
#include <span>
#include <tilemesh/engine/team.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/splat/blending.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/rules.hpp>
#include <tilemesh/splat/policies.hpp>
#include <vector>

namespace bench {

namespace splat = tilemesh::splat;

/// Blends the splats `splats[rows[0]]` to `splats[rows[n - 1]]`, front to back, into the pixels of a tile. `pixels` is the tile's first
/// pixel.
using BlendTile = splat::PairCount (*)(splat::PixelRect const& tile, splat::View const& view, std::uint32_t n,
                                       splat::Splat const* splats, std::uint32_t const* rows, splat::FloatPixel* pixels,
                                       std::uint32_t stride_px) noexcept;
/// Blends as the machine does.
splat::PairCount blend_as_the_machine(splat::PixelRect const& tile, splat::View const& view, std::uint32_t n,
                                      splat::Splat const* splats, std::uint32_t const* rows, splat::FloatPixel* pixels,
                                      std::uint32_t stride_px) noexcept;

/// A bare rasteriser for shared memory. It uses the mesh's kernels for projection and blending. Between them it sorts all splats by depth
/// once, and makes one list of splats for each tile of 32 x 20 pixels. It has no mesh and no copies, and keeps nothing from frame to frame.
/// The machine's frame is compared with it; its picture has the same bits.
class Direct {
public:
    struct Stages {
        double project = 0, sort = 0, bin = 0, blend = 0, total = 0; ///< milliseconds
    };

    /// Requires unique ids. Keeps a copy of the records, in the order of their ids.
    explicit Direct(std::span<splat::Gaussian const> gaussians);

    /// Renders one frame on the team's threads.
    void render(splat::Camera const& camera, splat::Rules const& rules, Team& team,
                BlendTile blend_tile = blend_as_the_machine);

    /// The stages of the last frame. The numbers below are of the last frame too.
    Stages const& stages() const noexcept { return stages_; }
    std::uint64_t pairs() const noexcept { return pairs_; }
    std::uint64_t pairs_contributing() const noexcept { return contributing_; }
    std::uint32_t visible() const noexcept { return visible_; }
    std::uint64_t entries() const noexcept { return list_.size(); } ///< in the lists of all tiles
    /// Is the picture equal to this image, bit for bit?
    bool equals(tilemesh::report::Image const& image) const noexcept;
    tilemesh::report::Image image() const;
    /// The bytes of host memory that it keeps.
    std::uint64_t bytes() const noexcept;

private:
    /// A visible splat in the sort. Depths are above 0, so their bits are in the order of the depths.
    struct Key {
        std::uint32_t depth;
        std::uint32_t row;
    };
    /// The tiles that a splat touches; both ends are inclusive.
    struct Range {
        std::uint16_t x0, x1, y0, y1;
    };
    /// The working memory of one thread.
    struct alignas(64) Share {
        std::vector<Key> keys, other;    ///< keys of its records, by depth after the sort; second buffer of the sort
        std::vector<std::int32_t> count; ///< for its part of the sorted splats: list entries per tile
        std::vector<std::uint32_t> next; ///< for each tile: the place of its next entry
        std::uint64_t evaluated = 0, contributing = 0;
    };

    void project(std::uint32_t thread, std::uint32_t threads, splat::View const& view);
    static void sort(Share& share);
    void merge(std::uint32_t thread, std::uint32_t threads);
    void count(std::uint32_t thread, std::uint32_t threads);
    void place();
    void fill(std::uint32_t thread, std::uint32_t threads);
    void blend(std::uint32_t thread, splat::View const& view, BlendTile blend_tile, tilemesh::engine::detail::Shares& tiles_left);

    std::vector<splat::Gaussian> gaussians_;
    std::vector<splat::Splat> splats_;
    std::vector<Range> ranges_;  ///< by row, for visible splats
    std::vector<Range> ordered_; ///< nearest first
    std::vector<Key> sorted_;
    std::vector<std::uint32_t> list_;  ///< rows, tile after tile, nearest first
    std::vector<std::uint32_t> begin_; ///< of each tile's list, and the end of the last
    std::vector<Share> shares_;
    std::vector<splat::FloatPixel> pixels_;
    splat::Tiling tiling_{};
    std::uint32_t width_ = 0, height_ = 0, visible_ = 0;
    Stages stages_;
    std::uint64_t pairs_ = 0, contributing_ = 0;
};

} // namespace bench
