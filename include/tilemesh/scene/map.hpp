#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/splat/gaussian.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// A map in host memory, from a file or from the built-in scene. It may be empty. The id of a Gaussian is 1 + its row in the file, so that
/// a report names rows that a user can find. The id of a rejected row stays unused.
struct Map {
    std::string name; ///< "sloth", or "built_in"
    std::string path; ///< the path as the user gave it; empty for the built-in map
    std::vector<splat::Gaussian> gaussians;
    std::uint32_t sh_degree = 0;    ///< degree of the harmonics; above 0 the colours in `gaussians` are not clamped
    std::vector<float> harmonics;   ///< for each Gaussian the array of splat::ShadedGaussian<sh_degree>; empty at degree 0
    std::uint64_t rejected = 0;     ///< number of rows that are not finite or have no rotation; the other rows are in `gaussians`
    std::vector<std::string> notes; ///< one line each: what the reader skipped or rejected, and why
};

}}} // namespace tilemesh::scene
