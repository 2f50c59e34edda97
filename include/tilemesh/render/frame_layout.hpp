#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
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
    return (size + part - 1) / part;
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
inline FrameLayout layout_frame(Cut const& cut, std::uint32_t width, std::uint32_t height, MachineSize const& machine,
                                std::uint32_t tile_pixels, char const* setup)
{
    auto const by = [](std::uint64_t w, std::uint64_t h) { return std::to_string(w) + " x " + std::to_string(h); };
    if (width == 0 || height == 0 || width > 65535 || height > 65535)
        throw Error("a frame of " + by(width, height) + " pixels (each side is 1 to 65,535); choose another size");
    if ((cut.grid.width == 0) != (cut.grid.height == 0) || (cut.tile.width == 0) != (cut.tile.height == 0))
        throw Error("a grid or tile with one side of 0 (0 means that both sides follow from the frame); give both sides");
    auto const tiling = tiling_for(cut, width, height);
    auto const tile_width = tiling.tile_width, tile_height = tiling.tile_height;
    Extent2 const grid = cut.grid.width != 0 && cut.grid.height != 0
                             ? cut.grid
                             : (cut.tile.width == 0 || cut.tile.height == 0 ? Extent2{40, 36}
                                                                            : Extent2{parts(width, tile_width), parts(height, tile_height)});
    if (std::uint64_t{grid.width} * tile_width < width || std::uint64_t{grid.height} * tile_height < height)
        throw Error("a grid of " + by(grid.width, grid.height) + " tiles of " + by(tile_width, tile_height) + " pixels (the frame is " +
                    by(width, height) + "); choose more or larger tiles");
    if (std::uint64_t{grid.width} * grid.height > machine.tiles)
        throw Error("a grid of " + by(grid.width, grid.height) + " = " + std::to_string(std::uint64_t{grid.width} * grid.height) +
                    " tiles (" + machine.name + " has " + std::to_string(machine.tiles) +
                    "); choose larger tiles, a smaller grid or another machine");
    if (std::uint64_t{tile_width} * tile_height > tile_pixels)
        throw Error("tiles of " + by(tile_width, tile_height) + " pixels (setup " + setup + " has a framebuffer of " +
                    std::to_string(tile_pixels) + " pixels a tile); choose smaller tiles, a smaller frame or another machine");
    return {Grid{grid.width, grid.height}, tiling};
}

/// Throws Error for a camera or a model that no frame can be rendered with.
inline void check_camera(splat::Camera const& camera)
{
    if (!(camera.near_depth > 0) || !(camera.fx > 0) || !(camera.fy > 0))
        throw Error("a camera whose near plane or focal length is not above 0 (nothing in front of it can be projected); "
                    "correct the camera");
}
inline void check_model(splat::Model const& model)
{
    if (!(model.alpha_min >= 0) || !(model.alpha_max >= 0) || !(model.transmittance_min >= 0) || !(model.dilation >= 0))
        throw Error("a model whose alpha_min, alpha_max, transmittance_min or dilation is negative or not a number (it would "
                    "blend what is not light); correct the model");
    for (float const v : model.background)
        if (!(v >= 0 && v <= 1)) throw Error("a background with a channel of " + std::to_string(v) + " (each is 0 to 1); correct the model");
}

} // namespace render
}} // namespace tilemesh
