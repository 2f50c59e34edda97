// EXPECT: a setup that names storage_slots, road_bytes, .* .its sizes are one value: they would change nothing.; give it static constexpr Sizes sizes
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/splat/frame_program.hpp>

struct Setup : tilemesh::splat::Lossless {
    static constexpr std::uint32_t road_bytes = 24000;
};

auto sizes() { return tilemesh::mesh_sizes<tilemesh::splat::Frame<Setup>, Setup::Machine, Setup>(); }
