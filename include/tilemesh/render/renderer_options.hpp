#pragma once
#include <cstdint>
#include <optional>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/splat/model.hpp>
#include <tilemesh/splat/quality.hpp>
#include <tilemesh/splat/sizes.hpp>
#include <tilemesh/splat/view.hpp>

namespace tilemesh { inline namespace v0_2 {

/// Options of a Renderer. A zero means: as the setup has it.
struct RendererOptions {
    std::uint32_t threads = 1;
    Extent2 grid{};                          ///< tiles; 0: follows from frame and tile, or 40 x 36
    Extent2 tile{};                          ///< pixels; 0: the frame spread evenly over the grid
    std::uint32_t hops = 0;                  ///< the most supersteps of routing, and of bloom, per frame; 0: until quiet
    std::uint32_t channel_slots = 0;         ///< a limit, at most the setup's
    std::uint32_t waiting_slots = 0;         ///< a limit for each of routing's FIFOs, at most the setup's
    std::uint32_t storage_slots = 0;         ///< a limit, at most the setup's
    std::optional<splat::Footprint> footprint{};
    std::optional<splat::Arithmetic> arithmetic{};
    std::optional<splat::Quality> quality{};  ///< `model()` begins with its two cut-offs instead of the setup's
    bool digest = false;
    /// The most passes of routing, and of bloom, in a run; a frame that needs more throws Error (MeshOptions::most_passes). 0: the value
    /// of the engine's own options. Engines without such a bound (PoplarMesh) ignore it.
    std::uint32_t most_passes = 0;
    /// Sizes that replace the setup's. The renderer throws Error if they do not fit into a tile's SRAM.
    std::optional<splat::Sizes> sizes{};
};

/// How a frame is cut into tiles: by `tile` if it is given, or else evenly over `grid`, or over 40 x 36 tiles.
inline splat::Tiling tiling_for(RendererOptions const& options, std::uint32_t width, std::uint32_t height) noexcept
{
    return render::tiling_for({options.grid, options.tile}, width, height);
}

}} // namespace tilemesh
