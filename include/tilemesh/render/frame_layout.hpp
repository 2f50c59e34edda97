#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/splat/view.hpp>

namespace tilemesh { inline namespace v0_2 {

/// Width and height of a grid in tiles, or of a tile in pixels. `{40, 36}` and `Grid{40, 36}` both give one.
struct Extent2 {
    std::uint32_t width = 0;
    std::uint32_t height = 0;

    constexpr Extent2() noexcept = default;
    constexpr Extent2(std::uint32_t w, std::uint32_t h) noexcept : width(w), height(h) {}
    constexpr Extent2(Grid grid) noexcept : width(grid.width), height(grid.height) {} // NOLINT(google-explicit-constructor)
    friend constexpr bool operator==(Extent2 const&, Extent2 const&) noexcept = default;
};

namespace render {

/// The user's wish for the division of a frame into tiles. A member that is zero follows from the other one. If both are zero, the grid is
/// 40 x 36 tiles.
struct Cut {
    Extent2 grid; ///< tiles
    Extent2 tile; ///< pixels
};

inline std::uint32_t parts(std::uint32_t size, std::uint32_t part) noexcept
{
    return static_cast<std::uint32_t>((std::uint64_t{size} + part - 1) / part);
}

/// The division of a frame into tiles: by `tile` if it is given, otherwise evenly over `grid`, or over 40 x 36 tiles if both are zero.
inline splat::Tiling tiling_for(Cut const& cut, std::uint32_t width, std::uint32_t height) noexcept
{
    auto tile = cut.tile;
    if (tile.width == 0 || tile.height == 0) {
        Extent2 const grid = cut.grid.width == 0 || cut.grid.height == 0 ? Extent2{40, 36} : cut.grid;
        tile = {parts(width, grid.width), parts(height, grid.height)};
    }
    return splat::make_tiling(width, height, tile.width, tile.height);
}

/// The grid and the tiling of a frame.
struct FrameLayout {
    Grid grid;
    splat::Tiling tiling;
};

/// The layout of a frame on a machine whose tiles have room for `tile_pixels` pixels. Throws Error if the frame does not fit; the error
/// names `setup`.
TILEMESH_HOST FrameLayout layout_frame(Cut const& cut, std::uint32_t width, std::uint32_t height, MachineSize const& machine,
                                       std::uint32_t tile_pixels, char const* setup);

/// Has the machine a layout for the frame?
TILEMESH_HOST bool fits(Cut const& cut, std::uint32_t width, std::uint32_t height, MachineSize const& machine, std::uint32_t tile_pixels) noexcept;

/// Throws Error for a frame's size that is not 1 to 65,535 pixels a side, and for a cut with one side of 0.
TILEMESH_HOST void check_size(std::uint32_t width, std::uint32_t height);
TILEMESH_HOST void check_cut(Cut const& cut);

/// Throws Error for a machine without workers, or with more than `most`: a tile counts the work of each.
TILEMESH_HOST void check_workers(MachineSize const& machine, std::uint32_t most);

/// Throws Error for a camera (scene::check_camera) or rules that no frame can be rendered with.
TILEMESH_HOST void check_camera(splat::Camera const& camera);
/// Throws Error for a lens that a program's tiles do not know: any that bends, without `bends`; a panorama, without `exact_rays`.
TILEMESH_HOST void check_lens(splat::Camera const& camera, bool bends, bool exact_rays);
TILEMESH_HOST void check_rules(splat::Rules const& rules);

} // namespace render
}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/render/detail/frame_layout_code.hpp>
#endif
