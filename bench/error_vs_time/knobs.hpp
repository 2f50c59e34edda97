#pragma once
#include <cstdint>
#include <tilemesh/splat/blending.hpp>
#include <tilemesh/render/host_form.hpp>

namespace error_vs_time {

namespace splat = tilemesh::splat;

/// The storage format of a projected record's shape. `half_factor`: the factor of the inverse covariance (1 / sqrt(a), b / a and sqrt(a /
/// determinant)) in half precision. `half_conic`: the inverse covariance itself in half precision.
enum class Shape : std::uint32_t { float32, half_factor, half_conic };
/// The rule for the term that takes a pixel's transmittance below the limit.
enum class Crossing : std::uint32_t { blend, drop };

/// Rules that the library does not offer; this bench measures them for comparison. The defaults are the library's rules. Members are whole
/// words, because they are broadcast to every tile.
struct Knobs {
    float sigmas = 0;                        ///< pixels beyond so many standard deviations along an axis get nothing; 0: no such limit
    Shape shape = Shape::float32;
    std::uint32_t key_bits = 32;             ///< number of high bits of the depth key that order splats; equal ones are ordered by id
    std::uint32_t degree = 5;                ///< degree of the polynomial of `fast`: 3, 4 or 5
    Crossing crossing = Crossing::blend;
    friend bool operator==(Knobs const&, Knobs const&) = default;
};
} // namespace error_vs_time
