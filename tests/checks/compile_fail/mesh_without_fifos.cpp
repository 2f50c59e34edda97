// EXPECT: a list with fewer slots than its program needs to make progress
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/splat/frame_program.hpp>

struct Setup : tilemesh::splat::Lossless {
    static constexpr tilemesh::splat::Sizes sizes{.storage = 100, .road = 9, .beam = 9, .waiting = 0, .tile_pixels = 64};
};

auto sizes() { return tilemesh::mesh_sizes<tilemesh::splat::Frame<Setup>, Setup::Machine, Setup>(); }
