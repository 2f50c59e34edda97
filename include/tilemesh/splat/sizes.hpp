#pragma once
#include <cstdint>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The sizes of a frame's lists on one tile, in slots. They are values: renderers, ledgers and meshes of other sizes share one type and
/// its code.
///
/// Start from a preset's sizes and change what you want: `auto sizes = splat::Lossless::sizes; sizes.storage = 700;`. Or name every member:
/// `Sizes{.storage = 700, .road = 200, ...}`. A mistyped name does not compile.
struct Sizes {
    std::uint32_t storage = 0;       ///< anchored records and copies, each with a mark, a projected record and a sort key
    std::uint32_t road = 0;          ///< messages of routing in one channel end
    std::uint32_t beam = 0;          ///< messages of bloom in one channel end
    std::uint32_t waiting = 0;       ///< messages in each of routing's two FIFOs; at least 1 where a frame holds
    std::uint32_t tile_pixels = 0;   ///< of the framebuffer
    bool lists_fit = true;           ///< marks, projected records and sort keys count against the SRAM
    bool one_channel_memory = false; ///< road and beam lie in the same SRAM

    friend constexpr bool operator==(Sizes const& a, Sizes const& b) noexcept
    {
        return a.storage == b.storage && a.road == b.road && a.beam == b.beam && a.waiting == b.waiting &&
               a.tile_pixels == b.tile_pixels && a.lists_fit == b.lists_fit && a.one_channel_memory == b.one_channel_memory;
    }
};

}}} // namespace tilemesh::splat
