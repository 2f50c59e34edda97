#pragma once
#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/number_text.hpp>
#include <utility>
#include <vector>

namespace bench {

/// The wall time since it was made or last read, in milliseconds.
class Stopwatch {
public:
    double lap() noexcept
    {
        auto const now = Clock::now();
        return std::chrono::duration<double, std::milli>(now - std::exchange(begin_, now)).count();
    }

private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point begin_ = Clock::now();
};

/// The value below which a share `share` of the samples lies, by linear interpolation between ranks; 0 if there are no samples.
inline double quantile(std::vector<double> samples, double share)
{
    if (samples.empty()) return 0;
    std::sort(samples.begin(), samples.end());
    double const rank = share * static_cast<double>(samples.size() - 1);
    auto const below = static_cast<std::size_t>(rank);
    auto const above = std::min(below + 1, samples.size() - 1);
    return samples[below] + (rank - static_cast<double>(below)) * (samples[above] - samples[below]);
}
inline double median(std::vector<double> samples)
{
    return quantile(std::move(samples), 0.5);
}

/// y = factor * x^exponent, fitted by least squares of log y over log x.
struct PowerLaw {
    double factor = 0, exponent = 0;
};
/// Requires positive values, and at least two different x.
inline PowerLaw fit_power(std::vector<double> const& x, std::vector<double> const& y)
{
    auto const n = static_cast<double>(x.size());
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        double const a = std::log(x[i]), b = std::log(y[i]);
        sx += a, sy += b, sxx += a * a, sxy += a * b;
    }
    double const exponent = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    return {std::exp((sy - exponent * sx) / n), exponent};
}
/// The slope of y over x, by least squares.
inline double fit_slope(std::vector<double> const& x, std::vector<double> const& y)
{
    auto const n = static_cast<double>(x.size());
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sx += x[i], sy += y[i], sxx += x[i] * x[i], sxy += x[i] * y[i];
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/// A uniform number in [0, 1): number `which` < 256 of record `record` (SplitMix64: Steele, Lea, Flood 2014).
inline double even(std::uint32_t record, std::uint32_t which) noexcept
{
    std::uint64_t h = (std::uint64_t{record} << 8 | which) * 0x9e3779b97f4a7c15u;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
    return static_cast<double>((h ^ (h >> 31)) >> 11) * 0x1p-53;
}

/// A number with `places` digits after the point.
inline constexpr auto& fixed = tilemesh::decimals;
/// A number as 1.2346e-03 with `places` digits after the point, "inf" or "NaN", independent of the locale.
inline std::string scientific(double value, int places)
{
    if (!std::isfinite(value)) return fixed(value, 0);
    std::array<char, 64> text{};
    auto const end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::scientific, places);
    return {text.data(), end.ptr};
}

} // namespace bench
