#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/view.hpp>
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

/// Adds this note for the view of these cameras, one at least, in which the plane hides most; none if it hides nothing.
inline void add_near_note(tilemesh::scene::Map const& map, std::vector<tilemesh::splat::Camera> const& cameras, std::vector<std::string>& notes)
{
    std::ptrdiff_t most = 0;
    for (auto const& camera : cameras) {
        auto const view = tilemesh::splat::make_view(camera, {});
        auto const hides = [&](auto const& g) { return tilemesh::scene::only_near_hides(g, view); };
        most = std::max(most, std::count_if(map.gaussians.begin(), map.gaussians.end(), hides));
    }
    if (most != 0) notes.push_back(near_note(static_cast<std::uint64_t>(most), cameras));
}

} // namespace shared
