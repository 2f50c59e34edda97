#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <tilemesh/splat/gaussian.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// What a reader does with a map whose means are far from 0 against their spread, as those of a georeferenced map are. A float32 has steps of
/// 0.5 at 5,000,000, so the Gaussians and the cameras would stand at wrong places.
enum class FarMeans : unsigned char {
    kept, ///< the means stay, and a note says how wide the steps are
    moved ///< an origin (`Map::origin`) is subtracted in double; subtract it from cameras too (`relative_to_origin`)
};

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
    std::array<double, 3> origin{}; ///< in the file's coordinates, the point that `gaussians` have at 0; (0, 0, 0) unless a reader moved the means
};

/// The note of every reader whose file says that the map was trained with anti-aliasing.
inline constexpr char const* antialiased_note = "trained with anti-aliasing; --antialias (splat::Coverage::preserved) applies it";

}}} // namespace tilemesh::scene
