#pragma once
#include <cstdint>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The capacities of a frame's lists on one tile, in slots. They are values, not types: renderers, ledgers and meshes of different sizes
/// share one type and its code.
///
/// Start from a preset's sizes and change single members: `auto sizes = splat::Lossless::sizes; sizes.storage = 700;`. Or name every
/// member: `Sizes{.storage = 700, .road = 200, ...}`. A mistyped name does not compile.
struct Sizes {
    std::uint32_t storage = 0;       ///< anchored records and copies; each slot also has a mark, a projected record and a sort key
    std::uint32_t road = 0;          ///< messages of routing in one channel end (one direction)
    std::uint32_t beam = 0;          ///< messages of bloom in one channel end (one direction)
    std::uint32_t waiting = 0;       ///< messages in each of routing's two FIFOs; at least 1 with `Hold`
    std::uint32_t tile_pixels = 0;   ///< pixels of the framebuffer
    bool lists_fit = true;           ///< marks, projected records and sort keys count against the SRAM
    bool one_channel_memory = false; ///< road and beam share one SRAM region

    friend constexpr bool operator==(Sizes const& a, Sizes const& b) noexcept
    {
        return a.storage == b.storage && a.road == b.road && a.beam == b.beam && a.waiting == b.waiting &&
               a.tile_pixels == b.tile_pixels && a.lists_fit == b.lists_fit && a.one_channel_memory == b.one_channel_memory;
    }
};

}}} // namespace tilemesh::splat
