#pragma once
#include <algorithm>
#include <cstddef>
#include <string>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/number_text.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace track {

namespace detail {
/// The median of these values; 0 if there is none.
inline double median(std::vector<float> values)
{
    if (values.empty()) return 0;
    auto const middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return double{*middle};
}
} // namespace detail

/// The median of the depths that are known; 0 if none is. Cost: a partial sort of the pixels.
inline double median_depth(report::Plane const& depth)
{
    std::vector<float> known;
    for (float const d : depth.values)
        if (d > 0 && d < 1e18f) known.push_back(d);
    return detail::median(std::move(known));
}
/// The median depth of the pixels that a view covers by more than a half; 0 if there is none.
inline double median_depth(report::Plane const& depth, report::Plane const& alpha)
{
    std::vector<float> covered;
    for (std::size_t i = 0; i < depth.values.size(); ++i)
        if (alpha.values[i] > 0.5f) covered.push_back(depth.values[i]);
    return detail::median(std::move(covered));
}

/// How far the median of a picture's known depths is from that of the map in the same view, in words: "8.1 at the median, 5 times the map's 1.62".
/// Empty if they are less than `factor` apart, or if no depth is known. A wrong unit or order of bytes does this: a robust cost takes all such depths
/// for outliers, so that the colours alone find the pose.
inline std::string depth_misfit(report::Plane const& measured, double of_map, double factor)
{
    auto const median = median_depth(measured);
    if (!(median > 0.0 && of_map > 0.0)) return {};
    double const ratio = median / of_map;
    if (ratio < factor && ratio * factor > 1.0) return {};
    return report::significant(median, 3) + " at the median, " + report::significant(ratio, 3) + " times the map's " + report::significant(of_map, 3);
}

}}} // namespace tilemesh::track
