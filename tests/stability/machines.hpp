#pragma once
#include "../standard.hpp"
#include <tilemesh/basic_renderer.hpp>

// The machines of the stability tests behind plain functions. Only machines.cpp instantiates renderers.
namespace stability {

enum class Kind {
    roomy, ///< hold; any number of tiles of up to 65,536 pixels, 25,000 records, 400-slot channels; pixels with depth and alpha
    drop,  ///< as roomy, but a full channel or storage drops messages; float pixels only
    mk2   ///< Lossless on Mk2: 40 x 36 tiles of up to 640 pixels
};

/// A renderer of one of the kinds, with its map. RendererOptions limit channels and storage as for a renderer.
class Runner {
public:
    virtual ~Runner() = default;

    virtual tilemesh::RenderedFrame render(tilemesh::splat::Camera const& camera) = 0;
    virtual tilemesh::splat::Rules& rules() = 0;
    virtual tilemesh::splat::Tiling tiling() = 0;
    virtual tilemesh::Grid grid() = 0;
    virtual void observe(tilemesh::Observer observer) = 0;

    /// Every id that the mesh owns (stored as anchored, under way or waiting), sorted. An id that is owned twice occurs twice.
    virtual std::vector<std::uint32_t> owned_ids() = 0;
    /// (id, index of the tile) of every record that is stored as anchored, sorted.
    virtual std::vector<std::pair<std::uint32_t, std::uint32_t>> owners() = 0;
    /// The tiles whose records differ from brute force for this view; see support::wrong_tiles.
    virtual std::uint32_t wrong_tiles(tilemesh::splat::Camera const& camera) = 0;
    /// The pixels that differ in any bit from the naive picture without the records that the frame's report lists as missing.
    virtual std::uint64_t differing_pixels(tilemesh::RenderedFrame const& frame, tilemesh::splat::Camera const& camera) = 0;
};

std::unique_ptr<Runner> make_runner(Kind kind, tilemesh::scene::Map const& map, tilemesh::RendererOptions options = {});

/// One frame of a new renderer.
tilemesh::RenderedFrame render(Kind kind, tilemesh::scene::Map const& map, tilemesh::splat::Camera const& camera,
                               tilemesh::RendererOptions options = {}, tilemesh::splat::Rules const* rules = nullptr);

/// Is every value of colour, depth and alpha finite?
inline bool finite(tilemesh::RenderedFrame const& f)
{
    // The exponent is all ones. Integers are compared, because this runs for every pixel of every frame.
    auto const all = [](std::vector<float> const& values) {
        return std::none_of(values.begin(), values.end(), [](float v) { return (__builtin_bit_cast(std::uint32_t, v) & 0x7f800000u) == 0x7f800000u; });
    };
    return all(f.image.rgb) && all(f.depth.values) && all(f.alpha.values);
}
inline bool same_bits(std::vector<float> const& a, std::vector<float> const& b)
{
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0);
}
/// Colour, depth and alpha.
inline bool same_picture(tilemesh::RenderedFrame const& a, tilemesh::RenderedFrame const& b)
{
    return a.image.width == b.image.width && same_bits(a.image.rgb, b.image.rgb) && same_bits(a.depth.values, b.depth.values) &&
           same_bits(a.alpha.values, b.alpha.values);
}

} // namespace stability
