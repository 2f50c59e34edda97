#pragma once
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/report/image.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// The error of a picture against its reference. Both are float frames, not clamped and not rounded to 8 bits. One level is 1/255. All
/// measures except SSIM and `share_over_one_level` are over the 3 * width * height channel values.
struct ErrorMeasures {
    double rmse;        ///< root mean square error, in units of the values
    double max_levels;  ///< largest absolute error, in levels
    double p999_levels; ///< the ceil(0.999 n)-th smallest of n absolute errors (nearest rank), in
                        ///< levels
    double psnr_db;     ///< -20 log10(rmse), peak 1.0; infinite for equal pictures
    double ssim;        ///< structural similarity, see `compare`; 1 for equal pictures
    double mae;         ///< mean absolute error, in units of the values
    double share_over_one_level; ///< share of pixels with a channel that is off by more than one
                                 ///< level, 0 to 1
};

/// Computes the error of `image` against `reference`.
///
/// SSIM is that of Wang et al. 2004: an 11 x 11 Gaussian window of sigma 1.5, K1 = 0.01, K2 = 0.03, L = 1. One window is centred on every
/// pixel; border pixels are repeated outwards, so that any size has a value. SSIM is the mean over all pixels and the three channels. All
/// sums are in double. SSIM is accurate for values below about 1e4, because variances are differences of squares.
///
/// Throws `tilemesh::Error` if the sizes differ, if a picture has no pixels, or if a value of either picture is not finite; the text names
/// the first such pixel. Cost: 40 bytes a pixel, and about 0.3 s for 1280 x 720.
TILEMESH_HOST ErrorMeasures compare(Image const& image, Image const& reference);

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/error_measures_code.hpp>
#endif
