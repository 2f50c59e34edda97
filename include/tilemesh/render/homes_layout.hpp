#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/splat/homes/fold.hpp>

/// The division of a frame among the tiles of the program of homes.
namespace tilemesh { inline namespace v0_2 { namespace render {

/// The division of a frame among the tiles, and the setup with the sizes and the district of this frame.
struct HomesLayout {
    Grid grid;
    splat::homes::Fold fold;
    Setup setup;
};

inline Grid homes_grid(RendererOptions const& options) noexcept
{
    return options.grid.width != 0 && options.grid.height != 0 ? Grid{options.grid.width, options.grid.height} : Grid{40, 36};
}

/// The options of an anchored renderer for the renderer of homes that takes over from it: limits above the slots of homes limit nothing.
TILEMESH_HOST RendererOptions within(Setup const& homes, RendererOptions options) noexcept;
/// Throws Error for limits above the slots that the setup has.
TILEMESH_HOST void check_limits(Setup const& homes, RendererOptions const& options);

/// A tile that holds fewer splats of a window than this needs many rounds. A map that leaves less room comes in chapters.
inline constexpr std::uint32_t least_held = 256;

/// The layout of a frame of `size` pixels for a map of `records` records. Throws Error if the frame or the grid is too large, if a district
/// is no power of 2, or if the slots do not fit into a tile's SRAM. Records without a home come in chapters.
TILEMESH_HOST HomesLayout layout_homes(Setup const& homes, RendererOptions const& options, Extent2 size, std::uint64_t records);

/// Do the setup's sizes fit on its machine, for frames of `size` pixels of a map of `records` records: a home for each, and no fewer held
/// splats? Then a preset that comes from another machine can keep them, without `on_machine`.
TILEMESH_HOST bool keeps_sizes(Setup const& homes, RendererOptions options, Extent2 size, std::uint64_t records);

/// Gives a setup of any district those of a renderer by value, with `side` tiles along a side. Throws Error for a setup of others.
TILEMESH_HOST void take_districts(Setup& homes, std::uint32_t side);

}}} // namespace tilemesh::render

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/render/detail/homes_layout_code.hpp>
#endif
