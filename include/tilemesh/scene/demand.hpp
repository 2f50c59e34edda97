#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/footprint.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// The resources that a machine needs to show a map along a path of cameras. `demand_of` computes it in one scan of the map.
struct Demand {
    std::uint64_t gaussians = 0;         ///< Gaussians of the map
    std::uint64_t views = 0;             ///< number of cameras in the path; 0: any camera may come
    std::uint32_t sh_degree = 0;         ///< the highest degree with a coefficient that is not 0
    std::uint64_t shaded = 0;            ///< records with such a coefficient
    float least_opacity = 1, greatest_opacity = 0;
    std::uint64_t nearly_opaque = 0;     ///< records whose opacity is above 0.99, where the paper clamps alpha
    std::uint64_t too_faint = 0;         ///< records whose opacity is under alpha_min: no view of any camera shows them
    std::uint64_t culled = 0;            ///< records with nothing on screen in any view of the path, including `too_faint`
    std::uint64_t nearer = 0;            ///< in the view that has most of them: records that only the near plane hides (`only_near_hides`)
    std::uint64_t ties = 0;              ///< in the first view: visible records whose depth another record has too
    std::uint32_t footprint_columns = 0; ///< width in tiles of the largest footprint, in the views that were scanned whole
    std::uint32_t footprint_rows = 0;
    bool moves = true;                   ///< two views differ, so anchors change
    bool spans = true;                   ///< a footprint touches two tiles or more
    std::vector<bool> visible;           ///< by row: has something on screen in a view of the path; empty: any row may have
    std::vector<std::uint64_t> scanned;  ///< `key_of` each view of the path, sorted

    TILEMESH_HOST static std::uint64_t key_of(splat::View view) noexcept; // FNV-1a hash (Fowler, Noll, Vo) of the view's bytes
    /// Does the map that `needed` returns suffice for this view?
    TILEMESH_HOST bool holds_for(splat::View const& view) const;
};

/// Would this Gaussian's mean be in the picture if there were no near plane? It is in front of the camera, not deeper than the plane, and its
/// opacity is not under alpha_min.
TILEMESH_HOST bool only_near_hides(splat::Gaussian const& g, splat::View const& view) noexcept;

/// The demand of a map whose cameras are not known: records may move, and footprints may span tiles. Throws `Error`
/// for a map whose harmonics do not fit its degree (`require_harmonics`).
TILEMESH_HOST Demand demand_of(Map const& map, splat::Rules const& rules = {});

/// What a renderer keeps of the demand to which its map was reduced: the views that it may render, and the records that were not loaded.
class LoadedViews {
public:
    LoadedViews() = default; ///< any view
    explicit LoadedViews(Demand const& demand)
    {
        demand_.scanned = demand.scanned;
        demand_.culled = demand.culled;
    }
    std::uint64_t culled() const noexcept { return demand_.culled; }
    /// Throws Error for a view that the demand was not made for.
    TILEMESH_HOST void require(splat::View const& view) const;

private:
    Demand demand_; ///< only these facts
};

/// One process that has all rows of a map. Other types for `demand_of` have these functions over several processes, each with a part of the
/// rows: sums, and maxima of words below 2^63, over all processes; the first process gets the items of all.
struct AllRows {
    void sum(std::uint64_t*, std::size_t) const noexcept {}
    void most(std::uint64_t*, std::size_t) const noexcept {}
    template <class T>
    void join(std::vector<T>&) const noexcept
    {}
};
/// The demand of a map in parts, without cameras, from that of this process's part.
template <class Processes>
Demand over_parts(Demand d, Processes const& all)
{
    constexpr std::uint64_t none = 0x7f800000; // above the bits of every opacity
    auto const bits = [](float opacity) { return std::uint64_t{__builtin_bit_cast(std::uint32_t, opacity)}; };
    std::uint64_t sums[] = {d.gaussians, d.shaded, d.nearly_opaque, d.too_faint};
    std::uint64_t most[] = {d.sh_degree, none - bits(d.least_opacity), bits(d.greatest_opacity)};
    all.sum(sums, 4);
    all.most(most, 3);
    d.gaussians = sums[0];
    d.shaded = sums[1];
    d.nearly_opaque = sums[2];
    d.too_faint = sums[3];
    d.sh_degree = static_cast<std::uint32_t>(most[0]);
    d.least_opacity = __builtin_bit_cast(float, static_cast<std::uint32_t>(none - most[1]));
    d.greatest_opacity = __builtin_bit_cast(float, static_cast<std::uint32_t>(most[2]));
    return d;
}

/// The number of views of a path for which every record is projected.
inline constexpr std::size_t views_scanned_whole = 16;

/// The demand along a path, under a model. Other cameras and other models may need more (`Demand::holds_for`). `tiling_of(camera)` returns
/// the tiling of that camera's frame. The scan stops after 200 million projections; records that it has not seen by then count as visible.
///
/// If the map is this process's part of a map, `all` adds up (AllRows). Every process then calls it with the same path. `visible` is of this
/// part, `ties` is right in the first process, and all other members are those of the whole map.
///
/// Cost: one projection for each record in each of the first 16 views. In later views, one projection for each record that no view has
/// shown yet.
template <std::invocable<splat::Camera const&> TilingOf, class Processes = AllRows>
Demand demand_of(Map const& map, std::span<splat::Camera const> path, splat::Rules const& rules, TilingOf const& tiling_of, Processes const& all = {})
{
    Demand d = over_parts(demand_of(map, rules), all);
    d.views = path.size();
    if (path.empty()) return d;
    d.moves = std::any_of(path.begin(), path.end(), [&](auto const& c) { return !splat::same_view(c, path.front()); });
    for (auto const& camera : path) d.scanned.push_back(Demand::key_of(splat::make_view(camera, rules)));
    std::sort(d.scanned.begin(), d.scanned.end());
    d.spans = false;
    d.visible.assign(map.gaussians.size(), false);

    constexpr std::uint64_t most_projections = 200'000'000;
    std::vector<std::uint32_t> unseen(map.gaussians.size());
    for (std::uint32_t row = 0; row < unseen.size(); ++row) unseen[row] = row;
    std::vector<float> depths;
    std::uint64_t projections = 0;
    for (std::size_t i = 0; i < path.size() && (d.moves || i == 0); ++i) {
        auto const view = splat::make_view(path[i], rules);
        auto const tiling = tiling_of(path[i]);
        bool const whole = i < views_scanned_whole || !d.spans;
        std::uint64_t nearer = 0;
        auto const project_row = [&](std::uint32_t row) {
            auto const s = splat::project(map.gaussians[row], view, tiling);
            ++projections;
            if (!s.visible()) {
                nearer += only_near_hides(map.gaussians[row], view) ? 1 : 0;
                return;
            }
            d.visible[row] = true;
            auto const tiles = splat::tiles_of(s, tiling);
            d.spans = d.spans || tiles.count() > 1;
            d.footprint_columns = std::max(d.footprint_columns, tiles.columns());
            d.footprint_rows = std::max(d.footprint_rows, tiles.rows());
            if (i == 0) depths.push_back(s.depth());
        };
        if (whole)
            for (std::uint32_t row = 0; row < map.gaussians.size(); ++row) project_row(row);
        else
            for (auto row : unseen) project_row(row);
        std::erase_if(unseen, [&](std::uint32_t row) { return d.visible[row]; });
        std::uint64_t words[] = {projections, d.spans ? 1u : 0u, nearer};
        all.sum(words, 3);
        d.nearer = std::max(d.nearer, words[2]);
        d.spans = words[1] != 0;
        if (words[0] > most_projections && i + 1 < path.size()) {
            for (auto row : unseen) d.visible[row] = map.gaussians[row].opacity >= rules.alpha_min;
            d.spans = true;
            break;
        }
    }
    d.culled = static_cast<std::uint64_t>(std::count(d.visible.begin(), d.visible.end(), false));
    all.sum(&d.culled, 1);
    std::uint64_t most[] = {d.footprint_columns, d.footprint_rows};
    all.most(most, 2);
    d.footprint_columns = static_cast<std::uint32_t>(most[0]);
    d.footprint_rows = static_cast<std::uint32_t>(most[1]);
    all.join(depths);
    std::sort(depths.begin(), depths.end());
    for (std::size_t i = 0; i < depths.size(); ++i)
        d.ties += (i > 0 && depths[i] == depths[i - 1]) || (i + 1 < depths.size() && depths[i] == depths[i + 1]) ? 1 : 0;
    return d;
}

/// Returns the map without the records that no view of the path shows, and without the coefficients that are 0 in all records. It is valid
/// only for the views of the demand's path. Throws `Error` if the demand is of another map, and as `require_harmonics`.
TILEMESH_HOST Map needed(Map map, Demand const& demand);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/demand_code.hpp>
#endif
