#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <tilemesh/report/resample.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {
namespace detail {

/// The weights of one output pixel along one axis, in units of 2^-22, for the input pixels from `first` on.
struct Taps {
    std::size_t first = 0;
    std::vector<std::int32_t> weights;
};
/// 22: eight bits of a value, two bits for sums of weights above 1 and the sign leave 22 of 32.
inline constexpr int tap_bits = 22;

/// Keys' cubic convolution with a = -0.5 (IEEE Trans. ASSP 29, 1981).
inline double cubic(double x)
{
    x = std::fabs(x);
    if (x < 1.0) return (1.5 * x - 2.5) * x * x + 1.0;
    if (x < 2.0) return -0.5 * (((x - 5.0) * x + 8.0) * x - 4.0);
    return 0.0;
}

/// The cubic, stretched by the ratio of the sizes if the picture shrinks, sampled at the centres of the input pixels, and normalised.
inline std::vector<Taps> taps_of(std::uint32_t from, std::uint32_t to)
{
    double const scale = static_cast<double>(from) / to, stretch = std::max(scale, 1.0), reach = 2.0 * stretch;
    std::vector<Taps> taps(to);
    std::vector<double> weights;
    for (std::uint32_t out = 0; out < to; ++out) {
        double const centre = (out + 0.5) * scale;
        auto const first = static_cast<std::int64_t>(std::max(centre - reach + 0.5, 0.0));
        auto const last = std::min(static_cast<std::int64_t>(centre + reach + 0.5), std::int64_t{from});
        weights.clear();
        double sum = 0.0;
        for (auto in = first; in < last; ++in) {
            weights.push_back(cubic((static_cast<double>(in) + 0.5 - centre) / stretch));
            sum += weights.back();
        }
        taps[out].first = static_cast<std::size_t>(first);
        for (double const weight : weights) taps[out].weights.push_back(static_cast<std::int32_t>(std::round(weight / sum * (1 << tap_bits))));
    }
    return taps;
}

/// The rounded, clamped level of a weighted sum of levels. `at(k)` is the level at the k-th tap.
template <class At>
std::uint8_t level_of(Taps const& taps, At const& at)
{
    std::int64_t sum = std::int64_t{1} << (tap_bits - 1);
    for (std::size_t k = 0; k < taps.weights.size(); ++k) sum += std::int64_t{taps.weights[k]} * at(taps.first + k);
    return static_cast<std::uint8_t>(std::clamp<std::int64_t>(sum >> tap_bits, 0, 255));
}

} // namespace detail

TILEMESH_HOST Image resized_as_photograph(Image const& photograph, std::uint32_t width, std::uint32_t height)
{
    if (photograph.width == 0 || photograph.height == 0 || photograph.rgb.size() != std::size_t{3} * photograph.width * photograph.height ||
        width < 1 || height < 1 || width > 65535 || height > 65535)
        throw Error("cannot resize a picture of " + std::to_string(photograph.width) + " x " + std::to_string(photograph.height) + " pixels to " +
                    std::to_string(width) + " x " + std::to_string(height) + " (each side is 1 to 65535); choose other sizes");
    std::vector<std::uint8_t> levels(photograph.rgb.size());
    std::transform(photograph.rgb.begin(), photograph.rgb.end(), levels.begin(),
                   [](float value) { return static_cast<std::uint8_t>(255.0 * std::clamp(static_cast<double>(value), 0.0, 1.0) + 0.5); });
    auto const across = detail::taps_of(photograph.width, width), down = detail::taps_of(photograph.height, height);
    std::vector<std::uint8_t> rows(std::size_t{3} * width * photograph.height);
    for (std::size_t y = 0; y < photograph.height; ++y)
        for (std::size_t x = 0; x < width; ++x)
            for (std::size_t c = 0; c < 3; ++c)
                rows[3 * (y * width + x) + c] =
                    detail::level_of(across[x], [&](std::size_t in) { return levels[3 * (y * photograph.width + in) + c]; });
    Image resized{width, height};
    for (std::size_t y = 0; y < height; ++y)
        for (std::size_t i = 0; i < std::size_t{3} * width; ++i)
            resized.rgb[3 * y * width + i] =
                static_cast<float>(detail::level_of(down[y], [&](std::size_t in) { return rows[3 * in * width + i]; })) / 255.0f;
    return resized;
}

}}} // namespace tilemesh::report
