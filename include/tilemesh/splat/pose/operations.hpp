#pragma once
#include <tilemesh/machine/operations.hpp>
#include <tilemesh/splat/pose/tile.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat::pose {

/// The operations on which the kernels of tracking spend their time, besides those of a frame. `mk2()` gives them prices.
struct Operation {
    enum Kind : std::uint32_t {
        moving_pair,   ///< a Gaussian-pixel pair that contributes, blended with the six derivatives of its colour
        moving_depth,  ///< the derivatives of the depth beside it
        splat_motions, ///< the six motions of a splat's power
        row,           ///< a residual and its derivatives, made and added to the sums of six unknowns, on all workers
        mean,          ///< a pixel that is averaged into a cell, with its target
        gradient       ///< a row by gradients, made and added to the sums of six unknowns, on one worker
    };
    static constexpr char const* names[] = {"moving_pair", "moving_depth", "splat_motions", "row", "mean", "gradient"};
};
using Operations = tilemesh::Operations<Operation>;

/// The rows of `cells` cells, in rows of six unknowns: a row with 8 unknowns adds 45 entries instead of 28.
constexpr std::uint32_t rows_of(std::uint32_t cells, Tracking const& t) noexcept
{
    std::uint32_t const rows = times(cells, 3 + (t.with_depth != 0 ? 1 : 0));
    return t.unknowns > motions ? rows / 28 * 45 + rows % 28 * 45 / 28 : rows;
}

/// The operations of forward mode on a tile of `n` splats, if all workers wait for the one with the most. A worker computes the motions of
/// all splats again for each of its rows of 16 pixels that is evaluated; this counts as if no row of pixels became opaque. Pairs that were
/// evaluated in vain are not counted.
inline Operations forward_operations(PixelRect const& tile, Tracking const& t, std::uint32_t n, std::uint32_t const* contributing,
                                     std::uint32_t workers) noexcept
{
    Operations o;
    if (tile.empty()) return o;
    std::uint32_t most = 0, rows = 0, pixels = 0;
    for (std::uint32_t w = 0; w < workers; ++w) most = contributing[w] > most ? contributing[w] : most;
    for (std::uint32_t y = tile.y0; y < tile.y1; ++y)
        for (std::uint32_t x = tile.x0 / block_width * block_width; x < tile.x1; x += block_width) {
            if (!is_chosen(t, x, y)) continue;
            ++rows;
            pixels += (x + block_width < tile.x1 ? x + block_width : tile.x1) - (x > tile.x0 ? x : tile.x0);
        }
    o[Operation::moving_pair] = times(most, workers);
    o[Operation::moving_depth] = t.with_depth != 0 ? times(most, workers) : 0;
    o[Operation::splat_motions] = times(times((rows + workers - 1) / workers, workers), n);
    o[Operation::row] = rows_of(pixels / (t.cell * t.cell), t);
    return o;
}

}}} // namespace tilemesh::splat::pose
