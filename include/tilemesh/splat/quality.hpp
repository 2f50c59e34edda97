#pragma once
#include <cstdint>
#include <tilemesh/splat/rules.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// The purpose of a picture. The first three are pairs of the two cut-offs, alpha_min and transmittance_min, which trade the picture's error
/// against its pairs; the other rules do not change. `training` names all rules of the picture, and only the arithmetic and the
/// background stay.
///
/// The figures below are from `bench/error_vs_time --quick`: Sloth, Salad and the built-in map at 640 x 360. Pairs are Gaussian-pixel
/// pairs, relative to the default's. The error is measured against a double-precision picture without cut-offs; colours are 0 to 1, a level
/// is 1/255. On each of the three maps all three qualities are Pareto-optimal: no other measured setting has fewer pairs and no larger
/// error. Smaller frames, which have smaller Gaussians, are farther from the Pareto front.
///
/// The cut-offs of `evaluation` change a pixel by less than half a level on these maps, and by less than one level on a map of 250,000
/// Gaussians. The rounding of float32 comes on top. It shows in the few pixels where two depths are closer than a float can tell: up to 4
/// levels in these views, 51 levels in one frame of recorded motion. The footprint three_sigma_square cuts at 0.011 of the opacity anyway,
/// so with it a smaller alpha_min gains little.
///
/// `training` has the rules of the rasteriser that 3D Gaussian Splatting trains with (Kerbl et al. 2023, diff-gaussian-rasterization):
/// - alpha is at most 0.99. A term whose alpha is below 1/255 is left out.
/// - A pixel stops before the term that would leave less than 1e-4.
/// - A splat is drawn in the tiles of 16 x 16 pixels that its three-sigma square touches, and nowhere else.
/// - Means at a depth of 0.2 or nearer are culled, whatever `Camera::near_depth` says.
/// - The slopes x/z and y/z are clamped at 1.3 tan(fov / 2), wherever the principal point is; the other qualities follow the picture's
///   borders. The dilation is 0.3.
/// - Colours are clamped at 0 from below only.
/// - Splats are in order of depth, then of id.
///
/// These differences remain:
/// - The rounding of float32: the covariance is kept in factors, so its determinant is never 0 or negative, and no power is positive. The
///   rasteriser culls a splat with determinant 0 and skips a positive power; in exact arithmetic neither occurs. A pixel where rounding
///   decides about a term, a stop, a tile or an order may differ by that term. With `fast`, alpha differs by up to 2e-5.
/// - The principal point is the camera's; the rasteriser knows only the middle of the picture. The field of view of the slopes' clamp is
///   width / fx, as there. So a window of a picture is not the window of its picture: its splats have other shapes.
/// - A quaternion may have any length; the rasteriser expects length 1, which its training code gives it.
/// - A record that is not finite, or has a colour above 1e6, is not drawn. A radius may exceed an integer's range.
enum class Quality : std::uint32_t {
    evaluation, ///< for comparing pictures: 1.4 times the pairs (1.5 times at 1280 x 720); RMSE 3e-5 to 7e-5, PSNR above 83 dB
    viewing,    ///< for looking at pictures: 0.9 times the pairs; RMSE 1.8e-3 to 3e-3, PSNR 50 to 55 dB
    on_sensor,  ///< for machines where each pair counts: 0.8 times the pairs; RMSE 3.3e-3 to 5.7e-3, PSNR 44 to 50 dB
    training    ///< for comparing with the rasteriser that trained the map: 1.0 times the pairs; RMSE 9e-4 to 1.5e-3, PSNR 56 to 60 dB
};

/// Returns "evaluation", "viewing", "on_sensor" or "training".
constexpr char const* name(Quality quality) noexcept
{
    return quality == Quality::evaluation  ? "evaluation"
           : quality == Quality::viewing   ? "viewing"
           : quality == Quality::on_sensor ? "on_sensor"
                                           : "training";
}

/// Returns `rules` with those of `quality`, for colours of 0 to 1. Compute a scene's demand with the returned rules, because the
/// demand depends on the rules that render.
constexpr Rules with_quality(Rules rules, Quality quality) noexcept
{
    switch (quality) {
    case Quality::evaluation:
        // 1/32 of a level. The terms that a pixel skips add up to at most 0.45 levels on three maps and 0.92 levels on one of 250,000
        // Gaussians. An opaque record's footprint is 1.27 times as wide as with 1/255. The splats behind 1e-4 add at most 0.026 levels.
        rules.alpha_min = 1.0f / 8160.0f;
        rules.transmittance_min = 1e-4f;
        break;
    case Quality::viewing:
        // Terms under two levels are skipped: an opaque footprint is 0.94 times as wide. The splats behind 5e-3 add at most 1.3 levels.
        rules.alpha_min = 1.0f / 128.0f;
        rules.transmittance_min = 5e-3f;
        break;
    case Quality::on_sensor:
        // Terms under four levels are skipped: an opaque footprint is 0.87 times as wide. The splats behind 1e-2 add at most 2.6 levels. A
        // limit of 3e-2 saves another 0.1 to 5 % of the pairs and costs 2.5 to 5 dB. On Sloth at 1280 x 720 it is 2 % behind the front.
        rules.alpha_min = 1.0f / 64.0f;
        rules.transmittance_min = 1e-2f;
        break;
    case Quality::training: // the constants of forward.cu and auxiliary.h
        rules.alpha_min = 1.0f / 255.0f;
        rules.alpha_max = 0.99f;
        rules.transmittance_min = 1e-4f;
        rules.stop = Stop::before_crossing;
        rules.footprint = Footprint::three_sigma_tiles;
        rules.near_plane = NearPlane::fixed;
        rules.dilation = 0.3f;
        rules.jacobian_limit = 1.3f;
        rules.slope_border = SlopeBorder::of_half_width;
        break;
    }
    return rules;
}

}}} // namespace tilemesh::splat
