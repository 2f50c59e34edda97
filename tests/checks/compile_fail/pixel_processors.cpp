// EXPECT: the program does not fit in a tile's SRAM
// EXPECT: SramBudget<.*PixelProcessors.*, .*, [0-9]+U?, 474U?>
#include <tilemesh/basic_renderer.hpp>

// The paper's pixel processor array, 10 bytes a pixel, and the least frame: one record, one pixel, nothing moves. It takes 484.
struct PixelProcessors {
    static constexpr char const* name = "pixel processors";
    static constexpr std::uint32_t tiles = 256 * 256;
    static constexpr std::uint32_t sram_bytes = 10;
    static constexpr std::uint32_t code_bytes = 0;
    static constexpr std::uint32_t workers = 1;
    static constexpr std::uint32_t clock_khz = 10'000;
};
struct Least : tilemesh::splat::Lossless {
    using Machine = PixelProcessors;
    using Pixel = tilemesh::splat::Rgbx8Pixel;
    static constexpr bool routes = false, blooms = false;
    static constexpr tilemesh::splat::Sizes sizes{.storage = 1, .tile_pixels = 1};
};
static_assert(tilemesh::bytes_needed<PixelProcessors, tilemesh::splat::Frame<Least>, Least> == 484);
static_assert(!tilemesh::fits<PixelProcessors, tilemesh::splat::Frame<Least>, Least>);

tilemesh::RenderedFrame render(tilemesh::scene::Map const& map, tilemesh::splat::Camera const& camera)
{
    return tilemesh::BasicRenderer<Least>{map}.render(camera);
}
