#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// Which pixels a splat may touch. A pixel outside the footprint gets nothing from it, on whatever tile it is.
enum class Footprint : std::uint32_t {
    opacity_box,       ///< half-widths t sqrt(a), t sqrt(c) with t = sqrt(2 ln(opacity / alpha_min)): no visible pixel is outside
    three_sigma_square ///< half-width ceil(3 sqrt(lambda_max)) both ways: the paper's, cuts at alpha = 0.011 opacity
};

/// How alpha is computed.
enum class Arithmetic : std::uint32_t {
    precise, ///< every Gaussian-pixel pair by itself: bit-identical to the naive loop
    fast     ///< down a column of 5 pixels by recurrence: within 2e-5 of alpha, bit-identical over tilings, engines and threads
};

/// The picture's rules besides the camera. The model proper (EWA, dilation, near plane, Jacobian clamp) is the same in the
/// kernels and in every reference; the cut-offs are what `error` in a report measures.
///
/// Constants: 1/255, 0.3, 1.3 and 3 sigma are those of 3D Gaussian Splatting (Kerbl et al. 2023).
struct Model {
    float alpha_min = 1.0f / 255.0f;    ///< a term below this is skipped
    float alpha_max = 1.0f;             ///< 0.99 in the paper's presets; it costs 2.5 levels where opaque layers overlap
    /// A pixel is finished once its transmittance is below; the term that crosses is blended. 3D Gaussian Splatting has 1e-4 and does
    /// not blend that term; 1e-4 costs 0.5 to 15 % more pairs here, for an RMSE 1 to 20 % smaller (bench/error_vs_time).
    float transmittance_min = 5e-3f;
    float dilation = 0.3f;              ///< pixels squared, added to both variances of the projected Gaussian
    float jacobian_limit = 1.3f;        ///< x/z and y/z are clamped to this many half fields of view in the Jacobian; 0: off
    Footprint footprint = Footprint::opacity_box;
    Arithmetic arithmetic = Arithmetic::precise;
};

}}} // namespace tilemesh::splat
