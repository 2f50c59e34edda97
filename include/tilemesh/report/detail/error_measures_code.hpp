#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/report/error_measures.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

namespace detail {

inline void expect_finite(Image const& image, std::string const& which)
{
    for (std::size_t i = 0; i < image.rgb.size(); ++i) {
        if (std::isfinite(image.rgb[i])) continue;
        auto const pixel = i / 3;
        throw Error("cannot compare (the " + which + " is not finite at pixel " + std::to_string(pixel % image.width) + ", " +
                    std::to_string(pixel / image.width) + ", channel " + std::to_string(i % 3) + "); find what rendered it: no measure covers it");
    }
}

/// The window of Wang et al. 2004: 11 taps per axis, sigma 1.5 pixels, sum 1.
constexpr int ssim_radius = 5;
inline std::array<double, 2 * ssim_radius + 1> ssim_window()
{
    std::array<double, 2 * ssim_radius + 1> taps{};
    double sum = 0.0;
    for (int i = -ssim_radius; i <= ssim_radius; ++i) {
        auto& tap = taps[static_cast<std::size_t>(i + ssim_radius)];
        tap = std::exp(-0.5 * i * i / (1.5 * 1.5));
        sum += tap;
    }
    for (auto& tap : taps) tap /= sum;
    return taps;
}

/// Weighted sums of a, b, a^2, b^2 and a b over a window.
using SsimMoments = std::array<double, 5>;

/// The values of a window outside the picture: those of the nearest border pixel, or 0.
enum class SsimBorder { repeated, zero };

/// Sum of `weight[k] * at(centre + k - radius)`. A position outside [0, size) is clamped, or adds 0.
template <SsimBorder border, class Moments>
SsimMoments ssim_blur(std::array<double, 2 * ssim_radius + 1> const& window, std::uint32_t centre, std::uint32_t size, Moments&& at)
{
    SsimMoments sum{};
    for (int k = -ssim_radius; k <= ssim_radius; ++k) {
        auto const position = std::int64_t{centre} + k;
        if (border == SsimBorder::zero && (position < 0 || position >= size)) continue;
        SsimMoments const moments = at(static_cast<std::uint32_t>(std::clamp(position, std::int64_t{0}, std::int64_t{size} - 1)));
        auto const weight = window[static_cast<std::size_t>(k + ssim_radius)];
        for (std::size_t m = 0; m < sum.size(); ++m) sum[m] += weight * moments[m];
    }
    return sum;
}

/// The mean over the pixels for which `counts(column, row)` is true, at least one.
template <SsimBorder border, class Counts>
double mean_ssim(Image const& image, Image const& reference, Counts const& counts)
{
    // K1 = 0.01, K2 = 0.03, L = 1: the constants of Wang et al. 2004.
    constexpr double c1 = 0.01 * 0.01;
    constexpr double c2 = 0.03 * 0.03;
    auto const window = ssim_window();
    auto const pixels = std::size_t{image.width} * image.height;
    std::vector<SsimMoments> rows(pixels);
    double sum = 0.0;
    std::size_t counted = 0;
    for (std::uint32_t channel = 0; channel < 3; ++channel) {
        // The window is separable, so blur along x, then along y.
        for (std::uint32_t y = 0; y < image.height; ++y)
            for (std::uint32_t x = 0; x < image.width; ++x)
                rows[std::size_t{y} * image.width + x] = ssim_blur<border>(window, x, image.width, [&](std::uint32_t column) {
                    double const a = image.pixel(column, y)[channel];
                    double const b = reference.pixel(column, y)[channel];
                    return SsimMoments{a, b, a * a, b * b, a * b};
                });
        for (std::uint32_t y = 0; y < image.height; ++y)
            for (std::uint32_t x = 0; x < image.width; ++x) {
                auto const [a, b, aa, bb, ab] = ssim_blur<border>(window, y, image.height, [&](std::uint32_t row) -> SsimMoments const& {
                    return rows[std::size_t{row} * image.width + x];
                });
                if (!counts(x, y)) continue;
                ++counted;
                double const luminance = (2.0 * a * b + c1) / (a * a + b * b + c1);
                double const structure = (2.0 * (ab - a * b) + c2) / (aa - a * a + bb - b * b + c2);
                sum += luminance * structure;
            }
    }
    return sum / static_cast<double>(counted);
}

/// Throws `Error` if two pictures differ in size, have no pixels, or have a value that is not finite.
inline void expect_comparable(Image const& image, Image const& reference)
{
    auto const size_of = [](Image const& of) { return std::to_string(of.width) + " x " + std::to_string(of.height); };
    if (image.width != reference.width || image.height != reference.height)
        throw Error("cannot compare (the picture is " + size_of(image) + ", the reference " + size_of(reference) + "); render both at one size");
    for (auto const* each : {&image, &reference})
        if (each->rgb.empty() || each->rgb.size() != std::size_t{3} * each->width * each->height)
            throw Error("cannot compare (" + std::to_string(each->rgb.size()) +
                        " floats are no picture of " + size_of(*each) + "); render a frame first");
    expect_finite(image, "picture");
    expect_finite(reference, "reference");
}

/// `other`, with the values of `picture` in each pixel of three NaN.
inline Image equal_where_masked(Image const& picture, Image other)
{
    for (std::size_t i = 0; i + 2 < other.rgb.size() && i + 2 < picture.rgb.size(); i += 3)
        if (std::isnan(other.rgb[i]) && std::isnan(other.rgb[i + 1]) && std::isnan(other.rgb[i + 2]))
            std::copy_n(picture.rgb.begin() + static_cast<std::ptrdiff_t>(i), 3, other.rgb.begin() + static_cast<std::ptrdiff_t>(i));
    return other;
}

} // namespace detail

TILEMESH_HOST ErrorMeasures compare(Image const& image, Image const& reference)
{
    detail::expect_comparable(image, reference);
    auto const count = image.rgb.size();
    std::vector<double> errors(count);
    double sum = 0.0;
    double sum_of_squares = 0.0;
    std::size_t pixels_over = 0;
    for (std::size_t i = 0; i < count; i += 3) {
        bool over = false;
        for (std::size_t k = i; k < i + 3; ++k) {
            double const error = std::abs(double{image.rgb[k]} - double{reference.rgb[k]});
            errors[k] = error;
            sum += error;
            sum_of_squares += error * error;
            over = over || 255.0 * error > 1.0;
        }
        pixels_over += over ? 1 : 0;
    }
    auto const n = static_cast<double>(count);

    // ceil(0.999 n) in integers, so that no rounding of 0.999 moves the rank.
    auto const rank = static_cast<std::ptrdiff_t>(count - count / 1000);
    auto const p999 = errors.begin() + (rank - 1);
    std::nth_element(errors.begin(), p999, errors.end());

    ErrorMeasures measures{};
    measures.rmse = std::sqrt(sum_of_squares / n);
    measures.max_levels = 255.0 * *std::max_element(p999, errors.end());
    measures.p999_levels = 255.0 * *p999;
    measures.psnr_db = measures.rmse > 0.0 ? -20.0 * std::log10(measures.rmse) : std::numeric_limits<double>::infinity();
    measures.ssim = measures.max_levels > 0.0 ? detail::mean_ssim<detail::SsimBorder::repeated>(image, reference, [](auto...) { return true; }) : 1.0;
    measures.mae = sum / n;
    measures.share_over_one_level = static_cast<double>(pixels_over) / (n / 3.0);
    return measures;
}

TILEMESH_HOST PictureMeasures compare_pictures(Image const& picture, Image const& other)
{
    auto const shown = detail::equal_where_masked(picture, other);
    detail::expect_comparable(picture, shown);
    double sum = 0.0, sum_of_squares = 0.0, largest = 0.0;
    std::size_t at = 0, counted = 0;
    for (std::size_t i = 0; i < picture.rgb.size(); ++i) {
        counted += std::isnan(other.rgb[i]) ? 0 : 1;
        double const difference = std::abs(double{picture.rgb[i]} - double{shown.rgb[i]});
        sum += difference;
        sum_of_squares += difference * difference;
        if (difference > largest) {
            largest = difference;
            at = i / 3;
        }
    }
    if (counted == 0) throw Error("cannot compare (no pixel of the reference counts); give a mask that leaves something");
    auto const n = static_cast<double>(counted);
    auto const counts = [&](std::uint32_t x, std::uint32_t y) { return !std::isnan(other.pixel(x, y)[0]); };
    PictureMeasures measures{};
    measures.psnr_db = sum_of_squares > 0.0 ? -10.0 * std::log10(sum_of_squares / n) : std::numeric_limits<double>::infinity();
    measures.ssim = largest > 0.0 ? detail::mean_ssim<detail::SsimBorder::zero>(picture, shown, counts) : 1.0;
    measures.l1 = sum / n;
    measures.largest = largest;
    measures.largest_at = {static_cast<std::uint32_t>(at % picture.width), static_cast<std::uint32_t>(at / picture.width)};
    return measures;
}

TILEMESH_HOST Image clamped(Image image)
{
    for (auto& value : image.rgb) value = value > 0.0f ? std::min(value, 1.0f) : 0.0f;
    return image;
}

TILEMESH_HOST Image error_picture(Image const& picture, Image const& reference)
{
    auto const other = detail::equal_where_masked(picture, reference);
    detail::expect_comparable(picture, other);
    Image error{picture.width, picture.height};
    double largest = 0.0;
    auto const difference = [&](std::size_t i) { return std::abs(double{picture.rgb[i]} - double{other.rgb[i]}); };
    for (std::size_t i = 0; i < error.rgb.size(); ++i) largest = std::max(largest, difference(i));
    if (largest > 0.0)
        for (std::size_t i = 0; i < error.rgb.size(); ++i) error.rgb[i] = static_cast<float>(difference(i) / largest);
    return error;
}

}}} // namespace tilemesh::report
