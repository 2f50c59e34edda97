#pragma once
#include <algorithm>
#include <cmath>
#include <common/statistics.hpp>
#include <cstring>
#include <limits>
#include <string>
#include <tilemesh/report/error_measures.hpp>
#include <tilemesh/report/image.hpp>
#include <vector>

namespace bench {

using tilemesh::report::Image;

inline bool same_bits(Image const& a, Image const& b)
{
    return a.rgb.size() == b.rgb.size() && std::memcmp(a.rgb.data(), b.rgb.data(), a.rgb.size() * sizeof(float)) == 0;
}
/// PSNR in dB; infinite for equal bits.
inline double psnr(Image const& image, Image const& exact)
{
    return same_bits(image, exact) ? std::numeric_limits<double>::infinity() : tilemesh::report::compare(image, exact).psnr_db;
}
inline std::string db(double value)
{
    return std::isinf(value) ? "exact" : fixed(value, 1);
}

/// Pictures side by side, with a white gap.
inline Image side_by_side(std::vector<Image> const& images)
{
    constexpr std::uint32_t gap = 8;
    std::uint32_t width = 0, height = 0;
    for (auto const& i : images) width += i.width + (width == 0 ? 0 : gap), height = std::max(height, i.height);
    Image all(width, height);
    std::fill(all.rgb.begin(), all.rgb.end(), 1.0f);
    std::uint32_t left = 0;
    for (auto const& i : images) {
        for (std::uint32_t y = 0; y < i.height; ++y)
            std::memcpy(all.pixel(left, y), i.pixel(0, y), std::size_t{3} * i.width * sizeof(float));
        left += i.width + gap;
    }
    return all;
}

} // namespace bench
