#pragma once
#include <common/scenes.hpp>
#include <cstdint>

namespace scaling {

/// A map of `gaussians` records from one distribution, and its camera. A map with n records has the first n records of any larger map.
///
/// Means are uniform over the frame and a tenth beyond it on each side, at depths of 2 to 6. Footprints have standard deviations of about 1
/// to 8 pixels at 1280 x 720, with axis ratios up to 7. Opacities are 0.05 to 0.6, so that light passes through some tens of layers. The
/// map is computed with integers, and `exp`, `log` and `sqrt` in double. With another `pixels_wide`, footprints have these sizes in a frame
/// that is so wide.
bench::Scene synthetic(std::uint32_t gaussians, tilemesh::scene::Size size, std::uint32_t pixels_wide = 1280);

} // namespace scaling
