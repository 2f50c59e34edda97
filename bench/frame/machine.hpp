#pragma once
#include <common/machine.hpp>
#include <cstdint>
#include <memory>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/model.hpp>
#include <tilemesh/splat/setup.hpp>

namespace frame {

using bench::Machine;

/// The stop of every machine here, and of what it is compared with: 3D Gaussian Splatting's, so that others can compare with what this
/// bench prints.
inline constexpr float stop_of_3dgs = 1e-4f;

/// Lossless with that stop.
struct Lossless : tilemesh::splat::Lossless {
    static constexpr float transmittance_min = stop_of_3dgs;
};

enum class Kind {
    paper, ///< the preset lossless on Mk2, 40 x 36 tiles
    large, ///< a test machine with storage for a quarter of a million records on a few tiles, 40 x 36 tiles
    wide   ///< lossless on 400 x 250 tiles, of which the frame occupies 40 x 36
};

std::unique_ptr<Machine> make_paper(tilemesh::scene::Map const&, tilemesh::splat::Arithmetic, std::uint32_t threads);
std::unique_ptr<Machine> make_large(tilemesh::scene::Map const&, tilemesh::splat::Arithmetic, std::uint32_t threads);
std::unique_ptr<Machine> make_wide(tilemesh::scene::Map const&, tilemesh::splat::Arithmetic, std::uint32_t threads,
                                   tilemesh::splat::Camera const&);
inline std::unique_ptr<Machine> make_machine(Kind kind, tilemesh::scene::Map const& map,
                                             tilemesh::splat::Arithmetic arithmetic, std::uint32_t threads,
                                             tilemesh::splat::Camera const& camera)
{
    if (kind == Kind::wide) return make_wide(map, arithmetic, threads, camera);
    return kind == Kind::paper ? make_paper(map, arithmetic, threads) : make_large(map, arithmetic, threads);
}

} // namespace frame
