#pragma once
#include <algorithm>
#include <limits>
#include <tilemesh/scene/near_plane.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

TILEMESH_HOST float near_of_depths(std::vector<float> depths)
{
    if (depths.empty()) return default_near;
    auto const middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
    std::nth_element(depths.begin(), middle, depths.end());
    return std::clamp(0.1f * *middle, std::numeric_limits<float>::min(), default_near);
}

}}} // namespace tilemesh::scene::detail
