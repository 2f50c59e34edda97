#pragma once
#include <cmath>
#include <tilemesh/splat/policies.hpp>
#include <type_traits>

TILEMESH_EXACT_BEGIN
namespace tilemesh::splat {

namespace detail {
inline float clamped(float v, float low, float high) noexcept
{
    return v < low ? low : v > high ? high : v;
}

/// Pixels are blended in blocks that lie on the frame's pixel grid, whatever the tiling: a block that a tile border cuts is
/// evaluated whole and masked. 16 x 4 divides the paper's 32 x 20 tile; its state is 1 KiB of stack, 1.5 KiB with depth.
inline constexpr std::uint32_t block_width = 16, block_height = 4;

/// How far v is from w beyond what rounding makes of two such numbers (2^-21 of them: 8 roundings); 0 for NaN. Of a needle whose
/// mean is far from the frame, v - w may be nothing but rounding.
inline float beyond_rounding(float v, float w) noexcept
{
    float const rounding = 0x1p-21f * (std::fabs(v) + std::fabs(w)), distance = std::fabs(v - w);
    return distance > rounding ? distance - rounding : 0.0f;
}

/// May a pixel of this block see the splat? The largest power over the block's pixel centres, from the point of the block
/// nearest to the mean in the splat's own metric: never wrong to say yes, and the margin (2 % of alpha and 1e-4 of the power)
/// is far above the rounding of either side. (x0, x1, y0, y1): the block's outermost pixel centres relative to the mean.
inline bool reaches(Splat const& s, float x0, float x1, float y0, float y1) noexcept
{
    // On the side of the block that faces the mean, the best point of the vertical and of the horizontal edge.
    float const x = clamped(0.0f, x0, x1), y = clamped(0.0f, y0, y1);
    float const best_y = clamped(s.slope * x, y0, y1);
    float const off1 = beyond_rounding(best_y, s.slope * x);
    float const power1 = s.along * x * x + s.across * off1 * off1;
    float const steep = s.across * s.slope;
    float const best_x = clamped(steep * y / (s.along + steep * s.slope), x0, x1);
    float const off2 = beyond_rounding(y, s.slope * best_x);
    float const power2 = s.along * best_x * best_x + s.across * off2 * off2;
    float const power = power1 > power2 ? power1 : power2;
    return !(power * (1.0f - 1e-4f) + 0.02f < s.faintest); // NaN says yes
}

/// The state of a block while it is blended. Dead lanes, outside the tile, have a negative transmittance.
struct Block {
    float transmittance[block_height][block_width];
    float red[block_height][block_width];
    float green[block_height][block_width];
    float blue[block_height][block_width];
    static constexpr bool has_depth = false;
};
struct DepthBlock : Block {
    float weight[block_height][block_width];
    float depth[block_height][block_width];
    static constexpr bool has_depth = true;
};

/// Blends one splat into a block; returns how many pixels took part. `xs`, `ys`: pixel centres relative to the principal point.
/// Every lane does what the naive loop does for its pixel: a lane that takes no part adds 0, which changes no bit.
template <class AnyBlock>
std::uint32_t blend(AnyBlock& block, Splat const& s, Model const& m, float const* xs, float const* ys, std::uint32_t column,
                           std::uint32_t row) noexcept
{
    auto const rect = s.rect();
    std::uint32_t contributing = 0;
    for (std::uint32_t j = 0; j < block_height; ++j) {
        if (row + j < rect.y0 || row + j >= rect.y1) continue;
        std::uint32_t hits = 0;
        for (std::uint32_t i = 0; i < block_width; ++i) {
            float alpha = alpha_at(s, xs[i], ys[j]);
            alpha = alpha < m.alpha_max ? alpha : m.alpha_max;
            float const t = block.transmittance[j][i];
            bool const takes_part = (column + i >= rect.x0) & (column + i < rect.x1) & (alpha >= m.alpha_min) &
                                    (t >= m.transmittance_min);
            float const weight = takes_part ? alpha * t : 0.0f;
            block.red[j][i] = multiply_add(weight, s.colour[0], block.red[j][i]);
            block.green[j][i] = multiply_add(weight, s.colour[1], block.green[j][i]);
            block.blue[j][i] = multiply_add(weight, s.colour[2], block.blue[j][i]);
            block.transmittance[j][i] = t - weight;
            if constexpr (AnyBlock::has_depth) {
                block.weight[j][i] = block.weight[j][i] + weight;
                block.depth[j][i] = multiply_add(weight, s.depth, block.depth[j][i]);
            }
            hits += takes_part ? 1 : 0;
        }
        contributing += hits;
    }
    return contributing;
}

template <class AnyBlock>
Blended blended(AnyBlock const& block, std::uint32_t row, std::uint32_t column) noexcept
{
    Blended b{{block.red[row][column], block.green[row][column], block.blue[row][column]}, block.transmittance[row][column], 0, 0};
    if constexpr (AnyBlock::has_depth) {
        b.weight = block.weight[row][column];
        b.depth = block.depth[row][column];
    }
    return b;
}

inline bool finished(Block const& block, float transmittance_min) noexcept
{
    for (auto const& row : block.transmittance)
        for (float t : row)
            if (t >= transmittance_min) return false;
    return true;
}
} // namespace detail

/// Blends the tile's pixels front to back, blend then stop: C += w c, T -= w with w = alpha T, until T < transmittance_min.
/// `precise` arithmetic: bit-identical to the naive per-pixel loop over the whole frame, for any tiling.
///
/// Requires a framebuffer of the tile's pixels (the host sizes it when it sets the tiling). Runs on all workers; each takes
/// whole blocks, so writes are disjoint. Cost: no exchange; 64 pairs for each splat that may be
/// seen in a block that is not finished.
template <class S>
struct Composite {
    static constexpr char const* name = "composite";
    static_assert(S::Machine::workers >= 1 && S::Machine::workers <= Work::max_workers,
                  "a machine with more workers than Work counts for; raise Work::max_workers");

    void operator()(Here here, Broadcast<FrameParameters> frame, Splats<S> const& splats, Order<S> const& order,
                    Framebuffer<S>& framebuffer, Work& work, Worker worker) const noexcept
    {
        using detail::block_height;
        using detail::block_width;
        Camera const& camera = frame->view.camera;
        Model const& model = frame->view.model;
        auto const tile = pixels_of(frame->tiling, camera, here.tile);
        std::uint32_t blocks = 0, contributing = 0, number = 0;
        if (!tile.empty()) {
            for (std::uint32_t by = tile.y0 / block_height * block_height; by < tile.y1; by += block_height)
                for (std::uint32_t bx = tile.x0 / block_width * block_width; bx < tile.x1; bx += block_width) {
                    if (number++ % worker.count != worker.index) continue;
                    composite_block(bx, by, tile, camera, model, splats, order, framebuffer, blocks, contributing);
                }
        }
        work.blocks[worker.index] = blocks;
        work.contributing[worker.index] = contributing;
    }

private:
    static void composite_block(std::uint32_t bx, std::uint32_t by, PixelRect const& tile, Camera const& camera,
                                Model const& model, Splats<S> const& splats, Order<S> const& order,
                                Framebuffer<S>& framebuffer, std::uint32_t& blocks, std::uint32_t& contributing) noexcept
    {
        using detail::block_height;
        using detail::block_width;
        float xs[block_width], ys[block_height];
        for (std::uint32_t i = 0; i < block_width; ++i) xs[i] = static_cast<float>(bx + i) + 0.5f - camera.cx;
        for (std::uint32_t j = 0; j < block_height; ++j) ys[j] = static_cast<float>(by + j) + 0.5f - camera.cy;
        std::conditional_t<S::Pixel::has_depth, detail::DepthBlock, detail::Block> block{};
        PixelRect const live{bx > tile.x0 ? bx : tile.x0, bx + block_width < tile.x1 ? bx + block_width : tile.x1,
                             by > tile.y0 ? by : tile.y0, by + block_height < tile.y1 ? by + block_height : tile.y1};
        for (std::uint32_t j = 0; j < block_height; ++j)
            for (std::uint32_t i = 0; i < block_width; ++i)
                block.transmittance[j][i] =
                    bx + i >= live.x0 && bx + i < live.x1 && by + j >= live.y0 && by + j < live.y1 ? 1.0f : -1.0f;

        std::uint32_t blended = 0;
        for (SortKey const& key : order) {
            Splat const& s = splats[key.slot];
            auto const rect = s.rect();
            if (rect.x0 >= live.x1 || rect.x1 <= live.x0 || rect.y0 >= live.y1 || rect.y1 <= live.y0) continue;
            if (!detail::reaches(s, xs[0] - s.mean_px[0], xs[block_width - 1] - s.mean_px[0], ys[0] - s.mean_px[1],
                                 ys[block_height - 1] - s.mean_px[1]))
                continue;
            contributing += detail::blend(block, s, model, xs, ys, bx, by);
            ++blocks;
            if (++blended % 8 == 0 && detail::finished(block, model.transmittance_min)) break;
        }
        for (std::uint32_t y = live.y0; y < live.y1; ++y)
            for (std::uint32_t x = live.x0; x < live.x1; ++x)
                framebuffer[(y - tile.y0) * (tile.x1 - tile.x0) + (x - tile.x0)] =
                    S::Pixel::make(detail::blended(block, y - by, x - bx));
    }
};

} // namespace tilemesh::splat
TILEMESH_EXACT_END
