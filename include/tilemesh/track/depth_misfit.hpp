#pragma once
#include <algorithm>
#include <cstddef>
#include <string>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/number_text.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace track {

/// How far the median of a picture's known depths is from that of the map in the same view, in words: "8.1 at the median, 5 times the map's 1.62".
/// Empty if they are less than `factor` apart, or if no depth is known. A wrong unit or order of bytes does this: a robust cost takes all such depths
/// for outliers, so that the colours alone find the pose. Cost: a partial sort of the pixels.
inline std::string depth_misfit(report::Plane const& measured, double of_map, double factor)
{
    std::vector<float> known;
    for (float const d : measured.values)
        if (d > 0 && d < 1e18f) known.push_back(d);
    if (known.empty() || !(of_map > 0.0)) return {};
    auto const middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
    std::nth_element(known.begin(), middle, known.end());
    double const ratio = double{*middle} / of_map;
    if (ratio < factor && ratio * factor > 1.0) return {};
    return report::significant(double{*middle}, 3) + " at the median, " + report::significant(ratio, 3) + " times the map's " +
           report::significant(of_map, 3);
}

}}} // namespace tilemesh::track
