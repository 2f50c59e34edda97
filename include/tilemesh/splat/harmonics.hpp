#pragma once
#include <cmath>
#include <cstdint>
#include <tilemesh/splat/projection.hpp>

TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace splat {

namespace detail {
/// The real spherical harmonics of degree 1 to `Degree` in direction `d`. Order and signs are those of 3D Gaussian Splatting (Kerbl et al.
/// 2023): the functions of odd order m carry the Condon-Shortley sign. The constants are sqrt(3 / 4 pi), sqrt(15 / 4 pi), sqrt(5 / 16 pi),
/// sqrt(35 / 32 pi), sqrt(105 / 4 pi), sqrt(21 / 32 pi) and sqrt(7 / 16 pi).
template <std::uint32_t Degree>
void harmonic_basis(Float3 const& d, float (&basis)[harmonics_per_channel(Degree)]) noexcept
{
    basis[0] = -0.48860251f * d.y;
    basis[1] = 0.48860251f * d.z;
    basis[2] = -0.48860251f * d.x;
    if constexpr (Degree >= 2) {
        float const xx = d.x * d.x, yy = d.y * d.y, zz = d.z * d.z;
        basis[3] = 1.0925484f * (d.x * d.y);
        basis[4] = -1.0925484f * (d.y * d.z);
        basis[5] = 0.31539157f * (2.0f * zz - xx - yy);
        basis[6] = -1.0925484f * (d.x * d.z);
        basis[7] = 0.54627422f * (xx - yy);
        if constexpr (Degree >= 3) {
            basis[8] = -0.59004359f * d.y * multiply_add(3.0f, xx, -yy);
            basis[9] = 2.8906114f * (d.x * d.y) * d.z;
            basis[10] = -0.45704580f * d.y * (4.0f * zz - xx - yy);
            basis[11] = 0.37317633f * d.z * multiply_add(-3.0f, xx + yy, 2.0f * zz);
            basis[12] = -0.45704580f * d.x * (4.0f * zz - xx - yy);
            basis[13] = 1.4453057f * d.z * (xx - yy);
            basis[14] = -0.59004359f * d.x * multiply_add(-3.0f, yy, xx);
        }
    }
}
/// The direction from the camera to the mean, of length 1. The mean is in front of the near plane, so its distance is not 0. The largest
/// component is first scaled to about 1, so that no square leaves the range of floats.
inline Float3 direction_of(Gaussian const& g, View const& view) noexcept
{
    Float3 d{g.mean_world[0] - view.camera.position[0], g.mean_world[1] - view.camera.position[1],
             g.mean_world[2] - view.camera.position[2]};
    float largest = std::fabs(d.x) > std::fabs(d.y) ? std::fabs(d.x) : std::fabs(d.y);
    largest = std::fabs(d.z) > largest ? std::fabs(d.z) : largest;
    float const shrink = inverse_of_power(power_of_two_below(largest));
    d = {d.x * shrink, d.y * shrink, d.z * shrink};
    float const per_length = 1.0f / std::sqrt(dot(d, d));
    return {d.x * per_length, d.y * per_length, d.z * per_length};
}
} // namespace detail

/// Sets the colour of `s` to the colour that the camera sees from its position. Requires a visible `s`. Returns false if a channel is NaN
/// or above `largest_colour`. `harmonics`: as in ShadedGaussian<Degree>.
template <std::uint32_t Degree>
bool shade(Gaussian const& g, float const* harmonics, View const& view, Splat& s) noexcept
{
    using namespace detail;
    Float3 const d = direction_of(g, view);
    float basis[harmonics_per_channel(Degree)];
    harmonic_basis<Degree>(d, basis);
    for (std::uint32_t channel = 0; channel < 3; ++channel) {
        float colour = g.colour[channel];
        for (std::uint32_t k = 0; k < harmonics_per_channel(Degree); ++k)
            colour = multiply_add(harmonics[3 * k + channel], basis[k], colour);
        if (!(colour <= largest_colour)) return false; // also NaN
        s.colour[channel] = colour > 0.0f ? colour : 0.0f;
    }
    return true;
}
template <std::uint32_t Degree>
bool shade(ShadedGaussian<Degree> const& g, View const& view, Splat& s) noexcept
{
    return shade<Degree>(g, g.harmonics, view, s);
}

/// Projects a record with harmonics. The result is the projection of its Gaussian part, with the colour that the camera sees from its
/// position, clamped at 0 from below. The result is invisible if that colour is not finite or above `largest_colour`.
///
/// Cost in addition to the projection: a square root, a division, and 3 multiply-adds a coefficient. A record that is not visible costs
/// nothing more.
template <class Optics = AnyLens, std::uint32_t Degree>
Splat project(ShadedGaussian<Degree> const& g, View const& view, TileSize const& tile) noexcept
{
    Splat s = project<Optics>(static_cast<Gaussian const&>(g), view, tile);
    if (!s.visible() || shade(g, view, s)) return s;
    return {};
}

}}} // namespace tilemesh::splat
TILEMESH_EXACT_END
