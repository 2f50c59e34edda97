#pragma once
#include <tilemesh/render/setup.hpp>
#include <tilemesh/splat/setup_types.hpp>

namespace scaling {

/// `lossless` with more slots and pixels per tile: room for every value of every axis. Capacity is address space, and costs no memory until
/// it is used.
inline tilemesh::render::Setup roomy_setup()
{
    auto setup = tilemesh::splat::setup_of<tilemesh::splat::Lossless>();
    setup.machine = tilemesh::size_of_machine<tilemesh::splat::RoomyMachine>();
    setup.sizes.storage = 40'000;         // Sloth on 10 x 9 tiles, a million Gaussians on 1,440
    setup.sizes.tile_pixels = 128 * 80;   // 1280 x 720 on 10 x 9 tiles; 3840 x 2160 on 40 x 36 has 96 x 60
    return setup;
}

} // namespace scaling
