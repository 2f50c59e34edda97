#pragma once
#include <cstdint>
#include <tilemesh/splat/model.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// What a picture is for: a named pair of the two cut-offs that trade its error against pairs, alpha_min and transmittance_min. All else
/// stays as the model has it.
///
/// What each costs (Gaussian-pixel pairs, against the default's) and gets wrong (the picture against a double-precision one without
/// cut-offs; colours of 0 to 1, a level is 1/255) is from `bench/error_vs_time --quick`: Sloth, Salad and the built-in map, 640 x 360.
/// On each of them all three are on the front of all settings measured: none has fewer pairs and no larger error. Smaller frames, of
/// smaller Gaussians, are farther off. What `evaluation` leaves out is below half a level there, below one level on a map of 250,000;
/// what float32 rounds comes on top, in the few pixels where two depths are closer than a float tells: up to 4 levels in these views,
/// 51 in one frame of recorded motion. With a three_sigma_square, which cuts at 0.011 of the opacity by itself, a smaller alpha_min
/// gains little.
enum class Quality : std::uint32_t {
    evaluation, ///< to compare pictures by: 1.4 times the pairs (1280 x 720: 1.5); RMSE 3e-5 to 7e-5, PSNR above 83 dB
    viewing,    ///< to look at: 0.9 times the pairs; RMSE 1.8e-3 to 3e-3, PSNR 50 to 55 dB
    on_sensor   ///< where every pair counts: 0.8 times the pairs; RMSE 3.3e-3 to 5.7e-3, PSNR 44 to 50 dB
};

/// "evaluation", "viewing" or "on_sensor".
constexpr char const* name(Quality quality) noexcept
{
    return quality == Quality::evaluation ? "evaluation" : quality == Quality::viewing ? "viewing" : "on_sensor";
}

/// The model with the cut-offs of a quality, for colours of 0 to 1. A scene's demand is made with the model that renders: with this one.
constexpr Model with_quality(Model model, Quality quality) noexcept
{
    switch (quality) {
    case Quality::evaluation:
        // 1/32 of a level: what a pixel skips adds up to 0.45 levels at the most on three maps, 0.92 on one of 250,000 Gaussians; an
        // opaque record's footprint is 1.27 times as wide as with 1/255. What lies behind 1e-4 is at most 0.026 levels.
        model.alpha_min = 1.0f / 8160.0f;
        model.transmittance_min = 1e-4f;
        break;
    case Quality::viewing:
        // Terms under two levels are skipped: an opaque footprint is 0.94 times as wide. What lies behind 5e-3 is at most 1.3 levels.
        model.alpha_min = 1.0f / 128.0f;
        model.transmittance_min = 5e-3f;
        break;
    case Quality::on_sensor:
        // Terms under four levels are skipped: an opaque footprint is 0.87 times as wide. What lies behind 1e-2 is at most 2.6
        // levels; 3e-2 saves another 0.1 to 5 % of the pairs and costs 2.5 to 5 dB: on Sloth at 1280 x 720 it is 2 % behind the front.
        model.alpha_min = 1.0f / 64.0f;
        model.transmittance_min = 1e-2f;
        break;
    }
    return model;
}

}}} // namespace tilemesh::splat
