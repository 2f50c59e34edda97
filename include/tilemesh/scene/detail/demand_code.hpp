#pragma once
#include <cstring>
#include <string>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/records.hpp>
#include <tilemesh/splat/lens_point.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene {

TILEMESH_HOST std::uint64_t Demand::key_of(splat::View view) noexcept
{
    view.rules.arithmetic = {}; // these do not change the demand
    view.rules.stop = {};
    view.rules.alpha_max = view.rules.transmittance_min = 0;
    for (float& channel : view.rules.background) channel = 0;
    unsigned char bytes[sizeof view];
    std::memcpy(bytes, &view, sizeof view);
    std::uint64_t key = 0xcbf29ce484222325u;
    for (unsigned char byte : bytes) key = (key ^ byte) * 0x100000001b3u;
    return key;
}

TILEMESH_HOST void LoadedViews::require(splat::View const& view) const
{
    if (!demand_.holds_for(view))
        throw Error("a view that the demand was not made for (" + std::to_string(demand_.culled) +
                    " records that its path does not show are not loaded); make the demand of all views, with the model");
}
TILEMESH_HOST bool Demand::holds_for(splat::View const& view) const
{
    return culled == 0 || std::binary_search(scanned.begin(), scanned.end(), key_of(view));
}

TILEMESH_HOST bool only_near_hides(splat::Gaussian const& g, splat::View const& view) noexcept
{
    auto const& c = view.camera;
    float along[3];
    for (int i = 0; i < 3; ++i) {
        along[i] = 0;
        for (int j = 0; j < 3; ++j) along[i] += c.rotation[i][j] * (g.mean_world[j] - c.position[j]);
    }
    auto const seen = splat::through_lens<float>(c, along);
    if (!(seen.seen && seen.depth <= c.near_depth && g.opacity >= view.rules.alpha_min)) return false;
    float const x = seen.at[0] + c.cx, y = seen.at[1] + c.cy;
    return x >= 0 && x < static_cast<float>(c.width) && y >= 0 && y < static_cast<float>(c.height);
}

TILEMESH_HOST Demand demand_of(Map const& map, splat::Rules const& rules)
{
    require_harmonics(map);
    Demand d;
    d.gaussians = map.gaussians.size();
    for (auto const& g : map.gaussians) {
        d.least_opacity = std::min(d.least_opacity, g.opacity);
        d.greatest_opacity = std::max(d.greatest_opacity, g.opacity);
        d.nearly_opaque += g.opacity > 0.99f ? 1 : 0;
        d.too_faint += g.opacity >= rules.alpha_min ? 0 : 1;
    }
    std::size_t const floats = 3 * splat::harmonics_per_channel(map.sh_degree);
    for (std::size_t row = 0; row < map.gaussians.size() && floats != 0; ++row) {
        auto const* const h = map.harmonics.data() + row * floats;
        auto used = floats;
        while (used > 0 && h[used - 1] == 0) --used;
        d.shaded += used != 0 ? 1 : 0;
        while (3 * splat::harmonics_per_channel(d.sh_degree) < used) ++d.sh_degree;
    }
    return d;
}

TILEMESH_HOST Map needed(Map map, Demand const& demand)
{
    require_harmonics(map);
    if (demand.gaussians != map.gaussians.size())
        throw Error("a demand of " + std::to_string(demand.gaussians) + " Gaussians (the map has " +
                    std::to_string(map.gaussians.size()) + "); make the demand of this map");
    if (!demand.visible.empty() && demand.visible.size() != map.gaussians.size())
        throw Error("a demand that says of " + std::to_string(demand.visible.size()) + " rows whether they are visible (the map has " +
                    std::to_string(map.gaussians.size()) + "); make the demand of this map");
    std::uint32_t const degree = std::min(demand.sh_degree, map.sh_degree);
    if (demand.visible.empty() && degree == map.sh_degree) return map;
    std::size_t const floats = 3 * splat::harmonics_per_channel(map.sh_degree);
    std::size_t const kept_floats = 3 * splat::harmonics_per_channel(degree);
    bool const clamp = map.sh_degree > 0 && degree == 0;
    std::size_t kept = 0;
    for (std::size_t row = 0; row < map.gaussians.size(); ++row) {
        if (!demand.visible.empty() && !demand.visible[row]) continue;
        map.gaussians[kept] = map.gaussians[row];
        if (clamp)
            for (float& c : map.gaussians[kept].colour) c = std::max(c, 0.0f);
        if (row * floats != kept * kept_floats)
            std::copy_n(map.harmonics.begin() + static_cast<std::ptrdiff_t>(row * floats), kept_floats,
                        map.harmonics.begin() + static_cast<std::ptrdiff_t>(kept * kept_floats));
        ++kept;
    }
    map.gaussians.resize(kept);
    map.harmonics.resize(kept * kept_floats);
    map.sh_degree = degree;
    return map;
}

}}} // namespace tilemesh::scene
