#pragma once
#include <common/machine.hpp>
#include <cstdint>
#include <memory>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/model.hpp>

namespace frame {

using bench::Machine;

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
