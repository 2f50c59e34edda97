#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tilemesh/report/image.hpp>
#include <tilemesh/splat/harmonics.hpp>
#include <vector>

TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace report {

/// Is this Gaussian missing from this pixel? Pass your own version to draw the picture of a mesh that lost records. This version: never.
struct NothingMissing {
    bool operator()(splat::GaussianId, std::uint32_t, std::uint32_t) const noexcept { return false; }
};

/// Renders the whole frame by a naive float32 loop, one Gaussian after the other over all its pixels: no tiles, no blocks, no lists. It
/// shares with the kernels only the functions `project` and `alpha_at`. If the mesh loses nothing, its picture is this picture, bit for
/// bit.
///
/// `gaussians` is a range of records of any degree.
template <class Records = std::span<splat::Gaussian const>, class Missing = NothingMissing>
Image render_naive(Records const& gaussians, splat::Camera const& camera, splat::Rules const& rules, Missing const& missing = {})
{
    auto const view = splat::make_view(camera, rules);
    auto const tiling = splat::make_tiling(camera.width, camera.height, camera.width, camera.height);
    struct Item {
        splat::Splat splat;
        splat::GaussianId id;
    };
    std::vector<Item> items;
    for (auto const& g : gaussians) {
        auto const s = splat::project(g, view, tiling);
        if (s.visible()) items.push_back({s, g.id});
    }
    std::sort(items.begin(), items.end(), [](Item const& a, Item const& b) {
        return a.splat.depth_key != b.splat.depth_key ? a.splat.depth_key < b.splat.depth_key : a.id < b.id;
    });

    float const lowest = splat::lowest_power_for(rules.alpha_min);
    Image image(camera.width, camera.height);
    std::vector<float> transmittance(std::size_t{camera.width} * camera.height, 1.0f);
    for (auto const& [s, id] : items) {
        auto const r = s.rect();
        for (auto y = r.y0; y < r.y1; ++y)
            for (auto x = r.x0; x < r.x1; ++x) {
                float& t = transmittance[std::size_t{y} * camera.width + x];
                if (t < rules.transmittance_min) continue;
                float const alpha = std::min(splat::alpha_at(s, static_cast<float>(x) + 0.5f - camera.cx,
                                                             static_cast<float>(y) + 0.5f - camera.cy, lowest),
                                             rules.alpha_max);
                if (alpha < rules.alpha_min || missing(id, x, y)) continue;
                float const weight = alpha * t;
                if (rules.stop == splat::Stop::before_crossing && t - weight < rules.transmittance_min) {
                    t = -t; // below any limit
                    continue;
                }
                float* const pixel = image.pixel(x, y);
                for (int c = 0; c < 3; ++c) pixel[c] = multiply_add(weight, s.colour[c], pixel[c]);
                t = t - weight;
            }
    }
    for (std::size_t i = 0; i < transmittance.size() && !splat::is_black(rules.background); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            image.rgb[3 * i + c] = multiply_add(std::fabs(transmittance[i]), rules.background[c], image.rgb[3 * i + c]);
    return image;
}

}}} // namespace tilemesh::report
TILEMESH_EXACT_END
