#pragma once
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/splat/policies.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

struct BlendAsAsked;

/// The members of a setup, in four groups: the machine (a type), the policies (types that change what kernels do), the sizes (one value,
/// `Sizes`), and the rules of the picture. Derive from a setup and change the members that you want to change. Every report shows the
/// setup's name.
///
/// Setups that differ only in machine, sizes or rules of the picture share all kernels.
struct SetupDefaults {
    using Machine = Mk2;

    using Record = Gaussian;                          ///< or ShadedGaussian<Degree>, for a colour that depends on the view
    using Projected = Splat;                          ///< an entry of Splats
    using Parameters = FrameParameters;               ///< the frame's broadcast
    using Routing = RowFirst;
    using Saturation = Hold;
    using Addressing = Carried;
    using Copies = WorldCopies;
    using Pixel = FloatPixel;
    using Blending = BlendAsAsked;                    ///< blending.hpp
    /// False: in each new view the host places every record on its anchor tile. A record that finds no room there is tried again in the
    /// next view.
    static constexpr bool routes = true;
    static constexpr bool blooms = true;              ///< false: no copies; the report lists a splat as lost on all tiles except its anchor

    static constexpr Footprint footprint = Footprint::opacity_box;
    static constexpr float alpha_max = 1.0f;
    static constexpr float transmittance_min = Rules{}.transmittance_min;
    /// Takes 0.70 to 0.74 times the host time of `precise`, and its error against the picture in double precision is not larger (measured
    /// by bench/frame and bench/error_vs_time).
    static constexpr Arithmetic arithmetic = Arithmetic::fast;
};

/// The default. No record is lost, pixels are floats, and the ledger holds everything that the kernels keep (622.3 KiB of Mk2's 624).
///
/// It has two sets of channels, the paper has one; each channel has half the paper's slots. With two real maps and motions up to 2 degrees
/// a frame, one channel carried at most 165 records (measured). A full channel costs passes, not records. FIFOs of 200 messages cost no
/// pass up to 100,000 records (measured).
struct Lossless : SetupDefaults {
    static constexpr char const* name = "lossless";
    /// One record in storage takes 136 bytes, including its mark, splat and sort key.
    static constexpr Sizes sizes{/*storage*/ 2000, /*road*/ 200, /*beam*/ 200, /*waiting*/ 200, /*tile_pixels*/ 32 * 20};
};

/// The paper's numbers (sections "Framebuffer Partitioning" and "Per-tile SRAM capacity"): 400-slot channels, 3,200 slots of 60 bytes,
/// RGBX8, 3-sigma squares, drop. The paper's budget has no room for render lists, FIFOs or credits. The ledger lists what our kernels keep
/// of these outside the budget.
struct Paper : SetupDefaults {
    static constexpr char const* name = "paper";
    using Saturation = Drop;
    using Addressing = Recomputed;
    using Pixel = Rgbx8Pixel;
    static constexpr Sizes sizes{/*storage*/ 3200,      /*road*/ 400,        /*beam*/ 400,             /*waiting*/ 0,
                                 /*tile_pixels*/ 32 * 20, /*lists_fit*/ false, /*one_channel_memory*/ true};
    static constexpr Footprint footprint = Footprint::three_sigma_square;
    static constexpr float alpha_max = 0.99f;
    static constexpr float transmittance_min = 1e-4f; ///< that of 3D Gaussian Splatting
};

/// The capacities that the authors' public code really has. That code steps through float buffers by a count of bytes, so a record takes
/// 240 bytes: the paper's 24,000-byte channel holds 100 records, its 192,000-byte storage 800. The ledger counts records of their true
/// size.
struct Prototype : Paper {
    static constexpr char const* name = "prototype";
    static constexpr Sizes sizes{/*storage*/ 800,       /*road*/ 100,        /*beam*/ 100,             /*waiting*/ 0,
                                 /*tile_pixels*/ 32 * 20, /*lists_fit*/ false, /*one_channel_memory*/ true};
};

/// A machine and sizes with room for a whole map and a whole frame on one tile. Channels keep their slots.
using RoomyMachine = TestMachine<64u << 20>;
constexpr Sizes roomy(Sizes sizes) noexcept
{
    sizes.storage = 40'000;
    sizes.tile_pixels = 1u << 20;
    sizes.lists_fit = true;
    return sizes;
}

}}} // namespace tilemesh::splat
