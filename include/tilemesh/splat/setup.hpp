#pragma once
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/splat/policies.hpp>

namespace tilemesh::splat {

struct BlendAsAsked;

/// What a Setup says: the machine, the policies, and the bytes of every region of a tile; slots follow from the size of a
/// record. Derive from one and change what you want; names appear in every report.
struct SetupDefaults {
    using Machine = Mk2;
    using Record = Gaussian;                          ///< or ShadedGaussian<Degree>, for colour that depends on the view
    using Projected = Splat;                          ///< an entry of Splats
    using Parameters = FrameParameters;               ///< the frame's broadcast
    using Routing = RowFirst;
    using Saturation = Hold;
    using Addressing = Carried;
    using Copies = WorldCopies;
    using Pixel = FloatPixel;
    using Blending = BlendAsAsked;                    ///< blending.hpp
    using ChannelRule = Limited;
    /// False: the host places each record on its anchor tile, view by view, and what found no room again in the next view.
    static constexpr bool routes = true;
    static constexpr bool blooms = true;              ///< false: nothing may touch two tiles; what does is listed as lost
    static constexpr bool one_channel_memory = false; ///< road and beam lie in the same SRAM
    static constexpr bool lists_fit = true;           ///< marks, projected records and sort keys count against the SRAM
    static constexpr Footprint footprint = Footprint::opacity_box;
    static constexpr float alpha_max = 1.0f;
    static constexpr float transmittance_min = Model{}.transmittance_min;
    /// 0.70 to 0.74 times the host time of `precise`, and no farther from the picture in double (README, "How fast it is").
    static constexpr Arithmetic arithmetic = Arithmetic::fast;

    template <class Message>
    static constexpr std::uint32_t slots(std::uint32_t bytes) noexcept
    {
        return bytes == dynamic_capacity ? dynamic_capacity : bytes / wire_bytes<Message>;
    }
};

/// The default: nothing is lost, float pixels, and a ledger that holds all that the kernels keep (622.3 KiB of Mk2's 624).
///
/// Two sets of channels instead of one, at half the paper's size: the most that two real maps and motions up to 2 degrees a
/// frame put into one channel is 165 records (measured), and a full channel costs supersteps, not records.
struct Lossless : SetupDefaults {
    static constexpr char const* name = "lossless";
    static constexpr std::uint32_t storage_slots = 2000;      ///< anchors and copies; 136 bytes each with marks, splats, keys
    static constexpr std::uint32_t road_bytes = 200 * sizeof(Addressed);
    static constexpr std::uint32_t beam_bytes = 200 * sizeof(Gaussian);
    static constexpr std::uint32_t waiting_bytes = 200 * sizeof(Addressed); ///< costs no superstep up to 100,000 records (measured)
    static constexpr std::uint32_t tile_pixels = 32 * 20;
};

/// The paper's numbers (sections "Framebuffer Partitioning" and "Per-tile SRAM capacity"): 400-slot channels, 3,200 slots of
/// 60 bytes, RGBX8, 3-sigma squares, drop. Its budget has no room for render lists, FIFOs or credits: what our kernels keep of
/// these is listed in the ledger, outside the budget.
struct Paper : SetupDefaults {
    static constexpr char const* name = "paper";
    using Saturation = Drop;
    using Addressing = Recomputed;
    using Pixel = Rgbx8Pixel;
    static constexpr bool one_channel_memory = true;
    static constexpr bool lists_fit = false;
    static constexpr Footprint footprint = Footprint::three_sigma_square;
    static constexpr float alpha_max = 0.99f;
    static constexpr float transmittance_min = 1e-4f; ///< that of 3D Gaussian Splatting
    static constexpr std::uint32_t storage_slots = 3200;
    static constexpr std::uint32_t road_bytes = 400 * sizeof(Gaussian);
    static constexpr std::uint32_t beam_bytes = 400 * sizeof(Gaussian);
    static constexpr std::uint32_t waiting_bytes = 0;
    static constexpr std::uint32_t tile_pixels = 32 * 20;
};

/// What the authors' public code really has room for: it steps through float buffers by a count of bytes, so that a record
/// takes 240 bytes and the paper's 24,000-byte channel holds 100, its 192,000-byte storage 800. The ledger is in real records.
struct Prototype : Paper {
    static constexpr char const* name = "prototype";
    static constexpr std::uint32_t storage_slots = 800;
    static constexpr std::uint32_t road_bytes = 100 * sizeof(Gaussian);
    static constexpr std::uint32_t beam_bytes = 100 * sizeof(Gaussian);
};

/// `Base` on a test machine with room for a whole map and a whole frame on one tile.
template <class Base>
struct Roomy : Base {
    using Machine = TestMachine<64u << 20>;
    static constexpr bool lists_fit = true;
    static constexpr std::uint32_t storage_slots = 40'000;
    static constexpr std::uint32_t tile_pixels = 1u << 20;
};

} // namespace tilemesh::splat
