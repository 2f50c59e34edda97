#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The rule that bounds the pixels a splat may touch. A pixel outside the footprint gets nothing from the splat, on every tile.
enum class Footprint : std::uint8_t {
    opacity_box,        ///< half-widths t sqrt(a), t sqrt(c) with t = sqrt(2 ln(opacity / alpha_min)); every visible pixel is inside
    three_sigma_square, ///< half-width ceil(3 sqrt(lambda_max)) in x and y, the paper's rule; it cuts at alpha = 0.011 opacity
    /// The part of the opacity box in those 16 x 16 pixel tiles that 3D Gaussian Splatting's rasteriser gives the splat to: the tiles that
    /// its three-sigma square touches. These tiles lie on the frame's pixel grid; they are not the mesh's tiles.
    three_sigma_tiles
};

/// The way in which alpha is computed.
enum class Arithmetic : std::uint8_t {
    precise, ///< each Gaussian-pixel pair on its own: bit-identical to the naive loop
    fast     ///< by recurrence down a column of 4 pixels: within 2e-5 of alpha, bit-identical over tilings, engines and threads
};

/// The term at which a pixel is finished.
enum class Stop : std::uint8_t {
    after_crossing, ///< the term that takes the transmittance below the limit is the last one that is blended
    before_crossing ///< that term is left out, the rule of 3D Gaussian Splatting; one rounding decides about up to alpha_max of what is left
};

/// The depth from which on a mean is visible.
enum class NearPlane : std::uint8_t {
    of_camera, ///< the camera's `near_depth`
    fixed      ///< `fixed_near_depth`, whatever the camera says
};
/// A mean at this depth or nearer is culled by 3D Gaussian Splatting's rasteriser, in world units.
inline constexpr float fixed_near_depth = 0.2f;

/// The border of the picture by which the Jacobian's slopes are bounded.
enum class SlopeBorder : std::uint8_t {
    of_picture,   ///< the border that is farther from the principal point: a window that keeps it has the bounds of its picture
    of_half_width ///< half of the picture's width or height, wherever the principal point is: the trainers' rule
};

/// The opacity of a splat whose covariance the dilation enlarges.
enum class Coverage : std::uint8_t {
    of_record, ///< the record's, so that a splat smaller than a pixel becomes brighter than it is
    preserved  ///< the record's times sqrt(det V / det(V + dilation)), at least 0.005: the light of the splat stays
};

/// The rules of the picture, apart from the camera. The kernels and all references use the same model proper (EWA, dilation, near plane,
/// Jacobian clamp). The cut-offs differ: `error` in a report measures their effect.
///
/// Sources: 1/255, 0.3, 1.3 and 3 sigma are the constants of 3D Gaussian Splatting (Kerbl et al. 2023). `Coverage::preserved` is the 2D Mip
/// filter (Yu et al. 2024) as 3D Gaussian Splatting's rasteriser has it under `antialiasing`, with its bound of 0.000025 under the root.
struct Rules {
    float alpha_min = 1.0f / 255.0f;    ///< a term with a smaller alpha is skipped
    float alpha_max = 1.0f;             ///< 0.99 in the paper's presets; there it costs 2.5 levels where opaque layers overlap
    /// A pixel is finished once its transmittance is below this limit; `stop` says whether the term that crosses the limit is blended. 3D
    /// Gaussian Splatting uses 1e-4. With `after_crossing` 1e-4 costs 0.5 to 15 % more pairs, for an RMSE that is 1 to 20 % smaller
    /// (bench/error_vs_time).
    float transmittance_min = 5e-3f;
    float dilation = 0.3f;              ///< pixels squared; added to both variances of the projected Gaussian
    float jacobian_limit = 1.3f;        ///< the Jacobian clamps x/z and y/z to this many distances to `slope_border`; 0: no clamp
    Footprint footprint = Footprint::opacity_box;
    Arithmetic arithmetic = Arithmetic::precise;
    Stop stop = Stop::after_crossing;
    NearPlane near_plane : 4;
    SlopeBorder slope_border : 2;
    Coverage coverage : 2;
    /// Linear RGB, 0 to 1. A pixel is C + T background, with the colour C that its splats give it and the transmittance T behind them.
    float background[3] = {0, 0, 0};
    /// The bounds of |x/z| and |y/z|; 0: `jacobian_limit` and the camera say them. A window of a picture that does not reach the picture's
    /// farther borders takes the picture's bounds (`bounds_of`).
    float slope_limit[2] = {0, 0};

    // Codelets are C++17, where bit-fields have no initialisers of their own.
    constexpr Rules() noexcept : near_plane(NearPlane::of_camera), slope_border(SlopeBorder::of_picture), coverage(Coverage::of_record) {}
};
static_assert(sizeof(Rules) == 44, "rules are plain words without padding: two of them are compared as bytes");

/// Is the background black? Then no pixel is touched for it.
constexpr bool is_black(float const (&background)[3]) noexcept
{
    return background[0] == 0 && background[1] == 0 && background[2] == 0;
}

}}} // namespace tilemesh::splat
