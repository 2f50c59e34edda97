#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tilemesh/render/frame_layout.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/report/frame_report.hpp>
#include <tilemesh/report/image.hpp>
#include <type_traits>
#include <utility>

namespace tilemesh { inline namespace v0_2 {

/// A picture and the report of its frame.
struct RenderedFrame {
    report::Image image;
    report::Plane depth; ///< view z in world units, 0 where no splat is; empty unless the setup's pixels have a depth (WithDepth)
    report::Plane alpha; ///< share of the pixel that is covered; empty unless the setup's pixels have an alpha (WithAlpha)
    report::FrameReport report;
};

namespace render {

/// What a prefetch did (FrameRenderer::prefetch). It lies between two frames, so no frame's report counts it. All 0 if the view is that of
/// the last frame.
struct Prefetched {
    std::uint64_t exchanges = 0, messages = 0;
    std::uint64_t exchanged_live_bytes = 0;
    std::uint64_t moved = 0; ///< records that left for another anchor tile
    double host_ms = 0;
};

/// Gives every tile a framebuffer with the pixels that it owns, all black. `wide`: the form of pixels that have two (machine/either.hpp).
template <class P, class Host>
void size_framebuffers(Host& host, splat::Tiling const& tiling, Extent2 size, bool wide = true)
{
    auto& mesh = host.mesh();
    splat::Camera frame{};
    frame.width = size.width;
    frame.height = size.height;
    auto const grid = mesh.grid();
    for (std::uint32_t t = 0; t < grid.size(); ++t) {
        if (!host.has(grid.tile(t))) continue;
        auto const rect = splat::pixels_of(tiling, frame, grid.tile(t));
        auto framebuffer = mesh.template state<splat::Framebuffer<P>>(grid.tile(t));
        std::uint32_t const n = rect.empty() ? 0 : (rect.x1 - rect.x0) * (rect.y1 - rect.y0);
        framebuffer.resize(n);
        machine::in_form(wide, framebuffer.begin(), [&]<class Pixel>(Pixel* pixels) {
            std::fill(pixels, pixels + n, Pixel::make(splat::nothing_blended));
        });
    }
}

namespace detail {
/// Rounds rows of floats to the levels of a machine with 8 bits per channel.
inline void round_to_levels(float* rgb, std::uint32_t floats) noexcept
{
    for (std::uint32_t i = 0; i < floats; ++i) rgb[i] = static_cast<float>(splat::Rgbx8Pixel::level(rgb[i])) / 255.0f;
}
inline void show(splat::FloatPixel const& p, std::uint32_t x, std::uint32_t y, RenderedFrame& to) noexcept
{
    for (std::uint32_t c = 0; c < 3; ++c) to.image.pixel(x, y)[c] = p.rgb[c];
}
inline void show(splat::Rgbx8Pixel const& p, std::uint32_t x, std::uint32_t y, RenderedFrame& to) noexcept
{
    for (std::uint32_t c = 0; c < 3; ++c) to.image.pixel(x, y)[c] = static_cast<float>(p.word >> (8 * c) & 255u) / 255.0f;
}
template <class Colour>
void show(splat::WithDepth<Colour> const& p, std::uint32_t x, std::uint32_t y, RenderedFrame& to) noexcept
{
    show(p.colour, x, y, to);
    if (to.depth.width != 0) to.depth.at(x, y) = p.depth;
}
template <class Colour>
void show(splat::WithAlpha<Colour> const& p, std::uint32_t x, std::uint32_t y, RenderedFrame& to) noexcept
{
    show(p.colour, x, y, to);
    if (to.alpha.width != 0) to.alpha.at(x, y) = p.alpha;
}
} // namespace detail

/// Gives a frame a picture of the camera's size, and those planes beside it that are wanted.
inline void size_planes(splat::Camera const& camera, bool depth, bool alpha, RenderedFrame& to)
{
    auto const size = [&](auto& plane, bool wanted) {
        if (!wanted)
            plane = {};
        else if (plane.width != camera.width || plane.height != camera.height)
            plane = std::remove_reference_t<decltype(plane)>(camera.width, camera.height);
    };
    size(to.image, true);
    size(to.depth, depth);
    size(to.alpha, alpha);
}

/// Copies the tiles of rows `first` to `last`-1 into a picture that begins with the pixels of row `first`.
template <class P, class M>
void copy_picture(M& mesh, Setup const& setup, splat::Tiling const& tiling, splat::Camera const& camera, std::uint32_t first,
                  std::uint32_t last, RenderedFrame& to)
{
    // The host may blend floats for a machine that stores levels; the result is then rounded to levels.
    bool const round = setup.colour == ColourFormat::rgbx8 && splat::colour_format<typename P::Pixel> == ColourFormat::float32;
    mesh.on_threads([&](std::uint32_t thread, std::uint32_t threads) {
        auto const top = first * tiling.tile_height; // of the picture
        auto const begin = std::uint64_t{first} * tiling.columns, tiles = std::uint64_t{last - first} * tiling.columns;
        for (auto t = begin + tiles * thread / threads; t < begin + tiles * (thread + 1) / threads; ++t) {
            auto const tile = TileId::at(static_cast<std::uint32_t>(t % tiling.columns), static_cast<std::uint32_t>(t / tiling.columns));
            auto const rect = splat::pixels_of(tiling, camera, tile);
            auto const framebuffer = std::as_const(mesh).template state<splat::Framebuffer<P>>(tile);
            auto const width = rect.x1 - rect.x0;
            machine::in_form(setup.has_planes(), framebuffer.begin(), [&]<class Pixel>(Pixel const* row) {
                for (auto y = rect.y0 - top; y < rect.y1 - top; ++y, row += width) {
                    if constexpr (std::is_same_v<Pixel, splat::FloatPixel>)
                        __builtin_memcpy(to.image.pixel(rect.x0, y), row, width * sizeof(splat::FloatPixel));
                    else
                        for (auto x = rect.x0; x < rect.x1; ++x) detail::show(row[x - rect.x0], x, y, to);
                    if (round) detail::round_to_levels(to.image.pixel(rect.x0, y), 3 * width);
                }
            });
        }
    });
}

} // namespace render
}} // namespace tilemesh
