// EXPECT: a machine with more workers than a kernel of this program has words for
#include <tilemesh/engine/mesh_sizes.hpp>
#include <tilemesh/splat/frame_program.hpp>

struct EightWorkers : tilemesh::Mk2 {
    static constexpr std::uint32_t workers = 8;
};
using Lossless = tilemesh::splat::Lossless;

auto sizes() { return tilemesh::mesh_sizes<tilemesh::splat::Frame<Lossless>, EightWorkers, Lossless>(); }
