#pragma once
#include <common/scenes.hpp>
#include <cstdint>

namespace scaling {

/// A map of `gaussians` records that all come from one distribution, and its camera: with n of them the first n of any larger map.
///
/// Means are even over the frame, and a tenth beyond it on each side, and over depths of 2 to 6; footprints have a standard
/// deviation of about 1 to 8 pixels at 1280 x 720 and axes up to 7 times as long as each other; opacities are 0.05 to 0.6, so that
/// light reaches some tens of layers. Integer arithmetic and `exp`, `log` and `sqrt` in double.
bench::Scene synthetic(std::uint32_t gaussians, tilemesh::scene::Size size);

} // namespace scaling
