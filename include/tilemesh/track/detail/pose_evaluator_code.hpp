#pragma once
#include <cstdint>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/track/pose_evaluator.hpp>

namespace tilemesh { inline namespace v0_2 {
namespace track {

TILEMESH_HOST Extent2 tracking_tile(Extent2 frame, MachineSize const& machine) noexcept
{
    Extent2 best{8, 8};
    std::uint64_t least = ~std::uint64_t{0};
    constexpr std::uint32_t most = 8 * splat::pose::most_cells_a_side; // sides that gradients of cells of 8 pixels have room for
    for (std::uint32_t w = 8; w <= most; w += 8)
        for (std::uint32_t h = 8; h <= most; h += 8) {
            if (std::uint64_t{render::parts(frame.width, w)} * render::parts(frame.height, h) > machine.tiles) continue;
            if (std::uint64_t const size = std::uint64_t{w} * h << 32 | (w + h); size < least) least = size, best = {w, h};
        }
    return best;
}

} // namespace track
}} // namespace tilemesh
