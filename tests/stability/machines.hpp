#pragma once
#include "../standard.hpp"
#include <tilemesh/renderer.hpp>

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

} // namespace stability
