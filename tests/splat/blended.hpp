// The blending kernels without a mesh: a frame's splats, front to back, blended tile by tile.
#pragma once
#include "support.hpp"
#include <tilemesh/splat/blending.hpp>

namespace support {

/// The default rules with a change.
inline tilemesh::splat::Rules with(void (*change)(tilemesh::splat::Rules&))
{
    tilemesh::splat::Rules m;
    change(m);
    return m;
}
/// Ordinary splats, needles, discs, opaque ones, and some as large as the frame.
inline std::vector<tilemesh::splat::Gaussian> varied(std::uint32_t n, std::uint32_t seed)
{
    auto gaussians = cloud(n, seed);
    for (auto& g : gaussians) {
        auto const id = static_cast<std::uint32_t>(g.id);
        if (id % 5 == 1) g.log_scale[0] += 2, g.log_scale[1] -= 4;
        if (id % 7 == 2) g.log_scale[2] -= 5;
        if (id % 11 == 3) g.opacity = 1;
        if (id % 13 == 4) g.opacity = 0.004f;
        if (id % 101 == 5) g.log_scale[0] += 4, g.log_scale[1] += 4;
    }
    return gaussians;
}

/// A frame's visible splats, front to back.
struct SortedSplats {
    std::vector<tilemesh::splat::Gaussian> gaussians;
    tilemesh::splat::Camera camera;
    tilemesh::splat::Rules rules;
    std::vector<tilemesh::splat::Splat> splats;

    SortedSplats(std::vector<tilemesh::splat::Gaussian> records, tilemesh::splat::Camera const& c, tilemesh::splat::Rules const& m = {})
        : gaussians(std::move(records)), camera(c), rules(m)
    {
        auto const view = tilemesh::splat::make_view(camera, rules);
        auto const tiling = tilemesh::splat::make_tiling(camera.width, camera.height, camera.width, camera.height);
        std::vector<std::pair<tilemesh::splat::Splat, tilemesh::splat::GaussianId>> items;
        for (auto const& g : gaussians)
            if (auto const s = tilemesh::splat::project(g, view, tiling); s.visible()) items.emplace_back(s, g.id);
        std::sort(items.begin(), items.end(), [](auto const& a, auto const& b) {
            return a.first.depth_key != b.first.depth_key ? a.first.depth_key < b.first.depth_key : a.second < b.second;
        });
        for (auto const& item : items) splats.push_back(item.first);
    }
};

/// The result of a kernel for a frame. Two results are equal if the pixels have the same bits.
struct Blended {
    std::vector<tilemesh::splat::FloatPixel> pixels;
    std::uint64_t evaluated = 0, contributing = 0; ///< pairs

    void count(tilemesh::splat::PairCount const& of_a_worker)
    {
        evaluated += std::uint64_t{of_a_worker.evaluated} * tilemesh::splat::pairs_a_count;
        contributing += of_a_worker.contributing;
    }
    bool operator==(Blended const& o) const
    {
        return pixels.size() == o.pixels.size() &&
               std::memcmp(pixels.data(), o.pixels.data(), pixels.size() * sizeof(tilemesh::splat::FloatPixel)) == 0;
    }
};

/// The frame in tiles of this size. `tile_kernel(tile, n, at, pixels, blended)` blends a tile's n splats, at(0) in front, into `pixels`,
/// whose rows have the frame's length, and counts.
template <class TileKernel>
Blended blended_in_tiles(SortedSplats const& scene, std::uint32_t tile_width, std::uint32_t tile_height, TileKernel&& tile_kernel)
{
    using namespace tilemesh;
    auto const& c = scene.camera;
    auto const tiling = splat::make_tiling(c.width, c.height, tile_width, tile_height);
    Blended out;
    out.pixels.resize(std::size_t{c.width} * c.height, splat::FloatPixel{{-7, -7, -7}}); // shows pixels that are not written
    for (std::uint32_t ty = 0; ty < tiling.rows; ++ty)
        for (std::uint32_t tx = 0; tx < tiling.columns; ++tx) {
            auto const tile = splat::pixels_of(tiling, c, TileId::at(tx, ty));
            std::vector<splat::Splat const*> list;
            for (auto const& s : scene.splats)
                if (splat::covers(s, tiling, TileId::at(tx, ty))) list.push_back(&s);
            auto const at = [&](std::uint32_t i) noexcept -> splat::Splat const& { return *list[i]; };
            tile_kernel(tile, static_cast<std::uint32_t>(list.size()), at,
                        out.pixels.data() + std::size_t{tile.y0} * c.width + tile.x0, out);
        }
    return out;
}

} // namespace support
