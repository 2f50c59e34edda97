#include "whole_frame.hpp"
#include "with_knobs.hpp"
#include <algorithm>
#include <bit>
#include <cstring>
#include <span>
#include <tilemesh/splat/project_all.hpp>
#include <vector>

TILEMESH_EXACT_BEGIN
namespace error_vs_time {

namespace {

using tilemesh::report::Image;

void blend_naive(std::vector<splat::Splat> const& nearest_first, splat::Camera const& camera, splat::Rules const& rules,
                 Crossing crossing, Image& image)
{
    std::vector<float> transmittance(std::size_t{camera.width} * camera.height, 1.0f);
    for (auto const& s : nearest_first) {
        auto const r = s.rect();
        for (auto y = r.y0; y < r.y1; ++y)
            for (auto x = r.x0; x < r.x1; ++x) {
                float& t = transmittance[std::size_t{y} * camera.width + x];
                if (t < rules.transmittance_min) continue;
                float const alpha = std::min(
                    splat::alpha_at(s, static_cast<float>(x) + 0.5f - camera.cx, static_cast<float>(y) + 0.5f - camera.cy),
                    rules.alpha_max);
                if (alpha < rules.alpha_min) continue;
                float const weight = alpha * t, left = t - weight;
                if (crossing == Crossing::drop && left < rules.transmittance_min) {
                    t = -1.0f;
                    continue;
                }
                float* const pixel = image.pixel(x, y);
                for (int c = 0; c < 3; ++c) pixel[c] = tilemesh::multiply_add(weight, s.colour[c], pixel[c]);
                t = left;
            }
    }
}

} // namespace

Image whole_frame(std::span<splat::Gaussian const> gaussians, splat::Camera const& camera, splat::Rules const& rules, Knobs const& knobs)
{
    auto const view = splat::make_view(camera, rules);
    auto const tiling = splat::make_tiling(camera.width, camera.height, camera.width, camera.height);
    std::vector<splat::Splat> projected(gaussians.size());
    splat::project_all(gaussians.data(), static_cast<std::uint32_t>(gaussians.size()), view, tiling, projected.data());
    for (auto& s : projected) apply(knobs, view, tiling, s);

    std::vector<std::uint32_t> rows;
    for (std::uint32_t i = 0; i < projected.size(); ++i)
        if (projected[i].visible()) rows.push_back(i);
    std::sort(rows.begin(), rows.end(), [&](std::uint32_t a, std::uint32_t b) {
        auto const key = [&](std::uint32_t i) { return key_of(knobs, projected[i].depth_key); };
        return key(a) != key(b) ? key(a) < key(b) : gaussians[a].id < gaussians[b].id;
    });
    std::vector<splat::Splat> nearest_first;
    for (auto const i : rows) nearest_first.push_back(projected[i]);

    Image image(camera.width, camera.height);
    if (rules.arithmetic == splat::Arithmetic::precise) {
        blend_naive(nearest_first, camera, rules, knobs.crossing, image);
        return image;
    }
    std::vector<splat::FloatPixel> pixels(std::size_t{camera.width} * camera.height, splat::FloatPixel{{0, 0, 0}});
    splat::PairCount pairs{};
    blend({0, camera.width, 0, camera.height}, view, knobs, static_cast<std::uint32_t>(nearest_first.size()),
          [&](std::uint32_t i) noexcept -> splat::Splat const& { return nearest_first[i]; }, pixels.data(), camera.width,
          tilemesh::Worker{0, 1}, &pairs, 1);
    std::memcpy(image.rgb.data(), pixels.data(), pixels.size() * sizeof(splat::FloatPixel));
    return image;
}

} // namespace error_vs_time
TILEMESH_EXACT_END
