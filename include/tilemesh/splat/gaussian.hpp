#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>
#include <type_traits>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The identity of a Gaussian, unique in its map. The value 0 marks a free slot and is never an id (the paper, section "Routing protocol").
enum class GaussianId : std::uint32_t { none = 0 };

/// One primitive of a map. It has the same colour from all sides. A tile stores this record, and a channel carries it: 60 bytes of plain
/// words (the paper's table in section "Gaussian Representation").
///
/// Spaces and units: `mean_world` is in world units. `colour` is linear RGB, `0.28209479 f_dc + 0.5`, clamped at 0 from below; do not clamp
/// it from above, because real maps reach 3.8. `opacity` is in [0, 1], after the sigmoid. `rotation` is a quaternion w, x, y, z of any
/// length except 0. `log_scale` is the natural logarithm of the standard deviation along each local axis.
struct Gaussian {
    static constexpr std::uint32_t sh_degree = 0;
    float mean_world[3];
    float colour[3];
    float opacity;
    float rotation[4];
    float log_scale[3];
    GaussianId id;
};
static_assert(sizeof(Gaussian) == 60 && alignof(Gaussian) == 4 && std::is_trivially_copyable_v<Gaussian>,
              "the record of the paper is 60 bytes");

/// The number of coefficients of one colour channel, from degree 1 to `degree` of the spherical harmonics: 3, 8 or 15.
constexpr std::uint32_t harmonics_per_channel(std::uint32_t degree) noexcept
{
    return degree * (degree + 2);
}

/// A Gaussian whose colour depends on the view direction. It has spherical harmonics up to `Degree`, 1 to 3, as 3D Gaussian Splatting
/// trains them (Kerbl et al. 2023): 96, 156 or 240 bytes.
///
/// `colour` is the part of degree 0. It is not clamped; the sum over all degrees is clamped. `harmonics` holds red, green and blue of the
/// first coefficient, then of the second, and so on. The coefficients are in the order of a channel's `f_rest_*` columns.
template <std::uint32_t Degree>
struct ShadedGaussian : Gaussian {
    static_assert(Degree >= 1 && Degree <= 3, "harmonics of degree 1, 2 or 3 (3D Gaussian Splatting trains no more); take one of "
                                              "these, or Gaussian for degree 0");
    static constexpr std::uint32_t sh_degree = Degree;
    float harmonics[3 * harmonics_per_channel(Degree)];
};
static_assert(sizeof(ShadedGaussian<1>) == 96 && sizeof(ShadedGaussian<2>) == 156 && sizeof(ShadedGaussian<3>) == 240 &&
                  std::is_trivially_copyable_v<ShadedGaussian<3>>,
              "a record is whole words, and no more than its degree needs");

namespace detail {
template <std::uint32_t Degree>
struct RecordOfDegree {
    using type = ShadedGaussian<Degree>;
};
template <>
struct RecordOfDegree<0> {
    using type = Gaussian;
};
} // namespace detail
/// The record type for a map of this degree.
template <std::uint32_t Degree>
using GaussianOfDegree = typename detail::RecordOfDegree<Degree>::type;

}}} // namespace tilemesh::splat
