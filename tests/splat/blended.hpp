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
        : gaussians(std::move(records)), camera(c), rules(m), splats(sorted_splats(gaussians, tilemesh::splat::make_view(camera, rules)))
    {
    }
};

/// The result of a kernel for a frame. Two results are equal if the pixels have the same bits, of as many contributing pairs.
template <class Pixel = tilemesh::splat::FloatPixel>
struct Blended {
    std::vector<Pixel> pixels;
    std::uint64_t evaluated = 0, contributing = 0; ///< pairs

    void count(tilemesh::splat::PairCount const& of_a_worker)
    {
        evaluated += std::uint64_t{of_a_worker.evaluated} * tilemesh::splat::pairs_a_count;
        contributing += of_a_worker.contributing;
    }
    bool operator==(Blended const& o) const { return contributing == o.contributing && same_bits(pixels, o.pixels); }
};
/// With the planes.
using DeepPixel = tilemesh::splat::WithAlpha<tilemesh::splat::WithDepth<tilemesh::splat::FloatPixel>>;

/// The frame in tiles of this size. `tile_kernel(tile, n, at, pixels, blended)` blends a tile's n splats, at(0) in front, into `pixels`,
/// whose rows have the frame's length, and counts.
template <class Pixel = tilemesh::splat::FloatPixel, class TileKernel>
Blended<Pixel> blended_in_tiles(SortedSplats const& scene, std::uint32_t tile_width, std::uint32_t tile_height, TileKernel&& tile_kernel)
{
    using namespace tilemesh;
    auto const& c = scene.camera;
    auto const tiling = splat::make_tiling(c.width, c.height, tile_width, tile_height);
    Blended<Pixel> out;
    out.pixels.resize(std::size_t{c.width} * c.height);
    std::memset(static_cast<void*>(out.pixels.data()), 0x7f, out.pixels.size() * sizeof(Pixel)); // shows pixels that are not written
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

/// The frame by the kernel of an arithmetic: one thread for all workers, or each of `workers` in turn.
template <std::uint32_t Lanes = tilemesh::splat::detail::lanes_in_use, class Pixel = tilemesh::splat::FloatPixel>
Blended<Pixel> blend(SortedSplats const& scene, tilemesh::splat::Arithmetic arithmetic, std::uint32_t tile_width, std::uint32_t tile_height,
                     std::uint32_t workers = 0)
{
    using namespace tilemesh::splat;
    Rules rules = scene.rules;
    rules.arithmetic = arithmetic;
    auto const& c = scene.camera;
    return blended_in_tiles<Pixel>(scene, tile_width, tile_height,
                                   [&](PixelRect const& tile, std::uint32_t n, auto const& at, Pixel* pixels, Blended<Pixel>& picture) {
                                       PairCount counts[6] = {};
                                       if (workers == 0) blend_whole_tile<Lanes>(tile, c, rules, n, at, pixels, c.width, counts, 6);
                                       for (auto const& count : counts) picture.count(count);
                                       for (std::uint32_t w = 0; w < workers; ++w)
                                           picture.count(blend_tile<Lanes>(tile, c, rules, n, at, pixels, c.width, tilemesh::Worker{w, workers}));
                                   });
}

TILEMESH_EXACT_BEGIN
/// The frame by a loop over the splats of each pixel. After the crossing: the term that leaves less than the limit counts, and ends the pixel.
/// Before it, as in 3D Gaussian Splatting: that term is left out.
inline Blended<> by_loop(SortedSplats const& v)
{
    using namespace tilemesh::splat;
    bool const drops = v.rules.stop == Stop::before_crossing;
    Blended<> out;
    for (std::uint32_t y = 0; y < v.camera.height; ++y)
        for (std::uint32_t x = 0; x < v.camera.width; ++x) {
            float through = 1, rgb[3] = {0, 0, 0};
            for (auto const& s : v.splats) {
                auto const r = s.rect();
                if (x < r.x0 || x >= r.x1 || y < r.y0 || y >= r.y1) continue;
                float const alpha = std::min(alpha_at(s, float(x) + 0.5f - v.camera.cx, float(y) + 0.5f - v.camera.cy), v.rules.alpha_max);
                if (alpha < v.rules.alpha_min) continue;
                float const weight = alpha * through, left = through - weight;
                if (drops && left < v.rules.transmittance_min) break;
                for (int c = 0; c < 3; ++c) rgb[c] = multiply_add(weight, s.colour[c], rgb[c]);
                through = left;
                ++out.contributing;
                if (through < v.rules.transmittance_min) break;
            }
            out.pixels.push_back({{rgb[0], rgb[1], rgb[2]}});
        }
    return out;
}
TILEMESH_EXACT_END

} // namespace support
