#pragma once
#include <array>
#include <cstdint>
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

/// The difference of a picture from a photograph, or from another renderer's picture, as the evaluation of 3D Gaussian Splatting measures
/// it. PSNR and L1 are over the 3 * width * height channel values; the peak is 1.0.
struct PictureMeasures {
    double psnr_db; ///< -10 log10 of the mean square difference; infinite for equal pictures
    double ssim;    ///< structural similarity, see `compare_pictures`; 1 for equal pictures
    double l1;      ///< mean absolute difference
    double largest; ///< largest absolute difference of a channel
    std::array<std::uint32_t, 2> largest_at; ///< column and row of its pixel, the first one in reading order; 0, 0 for equal pictures
};

/// Measures how far two pictures are from each other. It clamps nothing and rounds nothing: `clamped` does, for a photograph, whose
/// values are 0 to 1.
///
/// SSIM has the conventions of the evaluation script of 3D Gaussian Splatting: an 11 x 11 Gaussian window of sigma 1.5, K1 = 0.01,
/// K2 = 0.03, data range 1, each of the three channels alone, one window on every pixel, and **zeros outside the picture** (`compare`
/// repeats the border pixels; torchmetrics, which gsplat and nerfstudio use, leaves out windows that reach over the border). SSIM is the
/// mean over all pixels and channels. All sums are in double.
///
/// A pixel of `other` whose three values are NaN does not count (a mask left it out): the means and the largest difference are over the
/// others, and a window of SSIM sees two equal values there.
///
/// Throws `tilemesh::Error` as `compare` does, and if no pixel counts. Cost: 52 bytes a pixel, and about 0.3 s for 1280 x 720.
TILEMESH_HOST PictureMeasures compare_pictures(Image const& picture, Image const& other);

/// The picture with each value clamped to [0, 1], not rounded. A NaN becomes 0.
TILEMESH_HOST Image clamped(Image image);

/// The absolute difference of each channel, divided by the largest one, so that it shows 0 to 1. Black for equal pictures, and where
/// a pixel does not count. Throws `tilemesh::Error` as `compare_pictures` does.
TILEMESH_HOST Image error_picture(Image const& picture, Image const& other);

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/error_measures_code.hpp>
#endif
