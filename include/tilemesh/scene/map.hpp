#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/splat/gaussian.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// A map in host memory: what a file or the built-in scene gives; it may be empty. Ids are 1 + the row in the file, so that a
/// report names rows a user can find; rows that were rejected leave their id unused.
struct Map {
    std::string name; ///< "sloth", or "built_in"
    std::string path; ///< as the user gave it; empty for the built-in map
    std::vector<splat::Gaussian> gaussians;
    std::uint32_t sh_degree = 0;    ///< of the spherical harmonics; above 0 the colours in `gaussians` are not clamped
    std::vector<float> harmonics;   ///< for each Gaussian as in splat::ShadedGaussian<sh_degree>; empty at degree 0
    std::uint64_t rejected = 0;     ///< rows that are not finite or have no rotation; these and `gaussians` are all rows
    std::vector<std::string> notes; ///< one line each: what was skipped or rejected, and why
};

}}} // namespace tilemesh::scene
