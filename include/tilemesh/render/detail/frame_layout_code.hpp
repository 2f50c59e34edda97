#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/scene/pose.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {

TILEMESH_HOST void check_size(std::uint32_t width, std::uint32_t height)
{
    if (width == 0 || height == 0 || width > 65535 || height > 65535)
        throw Error("a frame of " + std::to_string(width) + " x " + std::to_string(height) +
                    " pixels (each side is 1 to 65,535); choose another size");
}
TILEMESH_HOST void check_cut(Cut const& cut)
{
    if ((cut.grid.width == 0) != (cut.grid.height == 0) || (cut.tile.width == 0) != (cut.tile.height == 0))
        throw Error("a grid or tile with one side of 0 (0 means that both sides follow from the frame); give both sides");
}

TILEMESH_HOST FrameLayout layout_frame(Cut const& cut, std::uint32_t width, std::uint32_t height, MachineSize const& machine,
                                       std::uint32_t tile_pixels, char const* setup)
{
    auto const by = [](std::uint64_t w, std::uint64_t h) { return std::to_string(w) + " x " + std::to_string(h); };
    check_size(width, height);
    check_cut(cut);
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

TILEMESH_HOST bool fits(Cut const& cut, std::uint32_t width, std::uint32_t height, MachineSize const& machine, std::uint32_t tile_pixels) noexcept
try {
    (void)layout_frame(cut, width, height, machine, tile_pixels, "");
    return true;
} catch (Error const&) {
    return false;
}

TILEMESH_HOST void check_workers(MachineSize const& machine, std::uint32_t most)
{
    if (machine.workers >= 1 && machine.workers <= most) return;
    auto const up_to = "1 to " + std::to_string(most);
    throw Error("machine " + std::string(machine.name) + " with " + std::to_string(machine.workers) + " workers (a tile counts the work of " + up_to +
                "); give the machine " + up_to + " workers");
}
TILEMESH_HOST void check_camera(splat::Camera const& camera)
{
    check_size(camera.width, camera.height);
    scene::check_camera(camera);
}
TILEMESH_HOST void check_lens(splat::Camera const& camera, bool bends, bool exact_rays)
{
    if (exact_rays) scene::check_no_shutter(camera, "a program of exact rays");
    else scene::check_no_panorama(camera, "this program of the tiles");
    if (!bends) scene::check_pinhole(camera, "this program of the tiles");
}
TILEMESH_HOST void check_rules(splat::Rules const& rules)
{
    if (!(rules.alpha_min >= 0) || !(rules.alpha_max >= 0) || !(rules.transmittance_min >= 0) || !(rules.dilation >= 0))
        throw Error("rules whose alpha_min, alpha_max, transmittance_min or dilation is negative or not a number (they would "
                    "blend what is not light); correct the rules");
    if (!(rules.slope_limit[0] >= 0) || !(rules.slope_limit[1] >= 0))
        throw Error("rules whose slope_limit is negative or not a number (0: the camera says it); correct the rules");
    for (float const v : rules.background)
        if (!(v >= 0 && v <= 1)) throw Error("a background with a channel of " + std::to_string(v) + " (each is 0 to 1); correct the rules");
}

}}} // namespace tilemesh::render
