#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The rule that bounds the pixels a splat may touch. A pixel outside the footprint gets nothing from the splat, on every tile.
enum class Footprint : std::uint32_t {
    opacity_box,       ///< half-widths t sqrt(a), t sqrt(c) with t = sqrt(2 ln(opacity / alpha_min)); every visible pixel is inside
    three_sigma_square ///< half-width ceil(3 sqrt(lambda_max)) in x and y, the paper's rule; it cuts at alpha = 0.011 opacity
};

/// The way in which alpha is computed.
enum class Arithmetic : std::uint32_t {
    precise, ///< each Gaussian-pixel pair on its own: bit-identical to the naive loop
    fast     ///< by recurrence down a column of 5 pixels: within 2e-5 of alpha, bit-identical over tilings, engines and threads
};

/// The rules of the picture, apart from the camera. The kernels and all references use the same model proper (EWA, dilation, near plane,
/// Jacobian clamp). The cut-offs differ: `error` in a report measures their effect.
///
/// Sources: 1/255, 0.3, 1.3 and 3 sigma are the constants of 3D Gaussian Splatting (Kerbl et al. 2023).
struct Model {
    float alpha_min = 1.0f / 255.0f;    ///< a term with a smaller alpha is skipped
    float alpha_max = 1.0f;             ///< 0.99 in the paper's presets; there it costs 2.5 levels where opaque layers overlap
    /// A pixel is finished once its transmittance is below this limit; the term that crosses the limit is blended. 3D Gaussian Splatting
    /// uses 1e-4 and does not blend that term. In this library 1e-4 costs 0.5 to 15 % more pairs, for an RMSE that is 1 to 20 % smaller
    /// (bench/error_vs_time).
    float transmittance_min = 5e-3f;
    float dilation = 0.3f;              ///< pixels squared; added to both variances of the projected Gaussian
    float jacobian_limit = 1.3f;        ///< the Jacobian clamps x/z and y/z to this many half fields of view; 0: no clamp
    Footprint footprint = Footprint::opacity_box;
    Arithmetic arithmetic = Arithmetic::precise;
};

}}} // namespace tilemesh::splat
