#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/splat/camera.hpp>
#include <vector>

namespace shared {

/// What the near plane hides: `n` Gaussians in one of these views. Requires a view.
inline std::string near_note(std::uint64_t n, std::vector<tilemesh::splat::Camera> const& path)
{
    auto const [least, most] = std::minmax_element(path.begin(), path.end(), [](auto const& a, auto const& b) { return a.near_depth < b.near_depth; });
    auto const number = [](float value) { return tilemesh::report::decimals(value, value < 0.01f ? 6 : 3); };
    auto const plane = number(least->near_depth) + (least->near_depth == most->near_depth ? "" : " to " + number(most->near_depth));
    return tilemesh::report::thousands(n) + (n == 1 ? " Gaussian" : " Gaussians") + (path.size() == 1 ? "" : " of one view") +
           " would be in the picture, but not beyond the near plane (" + plane + " world units), and " + (n == 1 ? "is" : "are") +
           " not drawn; --near moves it";
}

} // namespace shared
