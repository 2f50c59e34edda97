#pragma once
#include <cstdint>
#include <tilemesh/splat/blending.hpp>
#include <tilemesh/render/host_form.hpp>

namespace error_vs_time {

namespace splat = tilemesh::splat;

/// How the shape of a projected record is stored. `half_factor`: the factor of the inverse covariance, 1 / sqrt(a), b / a and
/// sqrt(a / determinant), in half precision. `half_conic`: the inverse covariance itself, in half precision.
enum class Shape : std::uint32_t { float32, half_factor, half_conic };
/// What happens to the term that takes a pixel's transmittance below the limit.
enum class Crossing : std::uint32_t { blend, drop };

/// Rules that the library does not offer and this bench measures beside it. The defaults are the library's own rules. Whole words,
/// because they are broadcast to every tile.
struct Knobs {
    float sigmas = 0;                        ///< no pixel beyond so many standard deviations along an axis; 0: no such cut
    Shape shape = Shape::float32;
    std::uint32_t key_bits = 32;             ///< of the depth's 32, from the highest, that order splats; ties by id
    std::uint32_t degree = 5;                ///< of the polynomial of `fast`: 3, 4 or 5
    Crossing crossing = Crossing::blend;
    friend bool operator==(Knobs const&, Knobs const&) = default;
};
} // namespace error_vs_time
