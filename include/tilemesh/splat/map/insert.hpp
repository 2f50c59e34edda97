#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>
#include <tilemesh/splat/bend.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/logarithm.hpp>
#include <tilemesh/splat/map/loss.hpp>
#include <tilemesh/splat/policies.hpp>
#include <tilemesh/splat/target_pixel.hpp>

/// How a map grows: which cells of a keyframe get a Gaussian, and which Gaussians go. No rule looks at another cell or another Gaussian, so
/// the result depends on no tiling. grow.hpp has the same as kernels of a mesh.
TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace splat::map {

/// When a cell gets a Gaussian: one condition is enough. The depth of at least one of its pixels must be known.
struct InsertRules {
    std::uint32_t cell = 2;     ///< pixels along a side; cells at the right and lower border may be smaller
    float least_cover = 0.5f;   ///< the map covers less than this, on the mean of the pixels
    float behind = 0.05f;       ///< the map is farther than the target by more than this share of its depth
    float colour_off = 0.15f;   ///< the mean difference of the colours is more than this
    float opacity = 0.73105858f; ///< of a new Gaussian: a logit of 1
    float deviation = 0.5f;     ///< standard deviation of a new Gaussian, in cells
};
/// When a Gaussian goes.
struct RemoveRules {
    float least_opacity = 0.018f; ///< it is less opaque than this
    float most_scale = 0.3f;      ///< an axis has a standard deviation above this, in units of the scene's depth
};

/// What the map shows in a pixel: the colour on the background, the depth (0 if at most half is covered), and the share that is covered.
struct ShownPixel {
    float rgb[3];
    float depth, cover;
};
inline ShownPixel shown(Blended const& p, float const (&background)[3]) noexcept
{
    ShownPixel s;
    for (std::uint32_t c = 0; c < 3; ++c) s.rgb[c] = multiply_add(p.transmittance, background[c], p.rgb[c]);
    s.cover = 1.0f - p.transmittance;
    s.depth = s.cover > least_covered ? p.depth / s.cover : 0.0f;
    return s;
}

/// The pixels of one cell, added up. A pixel with a colour that is not finite does not count; a depth that is not positive and finite is
/// not known.
struct CellSums {
    float rgb[3] = {}, off = 0; ///< of the target; the differences, over three channels
    float cover = 0, depth = 0, behind = 0;
    std::uint32_t pixels = 0, deep = 0; ///< that count; of these, with a known depth

    void add(TargetPixel const& target, ShownPixel const& shown) noexcept
    {
        constexpr float most = 1e18f;
        for (float const v : target.rgb)
            if (!(v > -most && v < most)) return;
        for (std::uint32_t c = 0; c < 3; ++c) {
            float const d = shown.rgb[c] - target.rgb[c];
            rgb[c] = rgb[c] + target.rgb[c];
            off = off + (d < 0 ? -d : d);
        }
        cover = cover + shown.cover;
        ++pixels;
        if (!(target.depth > 0 && target.depth < most)) return;
        depth = depth + target.depth;
        if (shown.depth > 0) behind = behind + (shown.depth - target.depth);
        ++deep;
    }
    float mean_depth() const noexcept { return depth / static_cast<float>(deep); }
    bool wants_gaussian(InsertRules const& r) const noexcept
    {
        if (deep == 0) return false;
        float const n = static_cast<float>(pixels);
        return cover < r.least_cover * n || behind > r.behind * depth || off > r.colour_off * (3.0f * n);
    }
};

/// An id has 20 bits for the cell, from 1, and 12 for the keyframe, from 1: a map of up to `most_cells` rows has no such id.
inline constexpr std::uint32_t most_cells = (1u << 20) - 1, most_keyframes = (1u << 12) - 1;
constexpr GaussianId id_of_cell(std::uint32_t keyframe, std::uint32_t cell) noexcept
{
    return static_cast<GaussianId>(keyframe << 20 | (cell + 1));
}

/// The cells of a picture, row by row.
struct CellGrid {
    std::uint32_t cell, columns, rows;

    static constexpr CellGrid of(std::uint32_t width, std::uint32_t height, std::uint32_t cell) noexcept
    {
        return {cell, width / cell + (width % cell != 0 ? 1u : 0u), height / cell + (height % cell != 0 ? 1u : 0u)};
    }
};

/// The Gaussian of the cell in this column and row: at the cell's middle and mean depth, the same along all axes, with the target's mean
/// colour. Requires `of.wants_gaussian`, and a keyframe and cells within the bounds of ids. Cost: seven divisions and a logarithm.
inline Gaussian gaussian_of_cell(CellSums const& of, Camera const& c, CellGrid const& grid, std::uint32_t column, std::uint32_t row,
                                 std::uint32_t keyframe, InsertRules const& r) noexcept
{
    auto const middle = [](std::uint32_t at, std::uint32_t cell, std::uint32_t size) {
        std::uint32_t const begin = at * cell, end = size - begin < cell ? size : begin + cell;
        return 0.5f * static_cast<float>(begin + end);
    };
    float const depth = of.mean_depth(), n = static_cast<float>(of.pixels);
    float const x = middle(column, grid.cell, c.width) - c.cx, y = middle(row, grid.cell, c.height) - c.cy;
    float sx = x / c.fx, sy = y / c.fy, size = r.deviation * static_cast<float>(grid.cell) * depth / c.fx;
    float ahead = 1;
    using splat::detail::OneFloat;
    if (c.lens.kind == LensKind::fisheye) {
        auto const ray = splat::detail::LensRay<OneFloat>(c, sx, sy).ray;
        float const sine = std::sqrt(multiply_add(ray.x, ray.x, ray.y * ray.y));
        splat::detail::FisheyeDistance<OneFloat> const at(c.lens, splat::detail::angle_of<OneFloat>(ray.z, sine));
        size = size / std::sqrt(at.slope * (sine > 0 ? at.theta * at.factor / sine : 1.0f)); // across the ray: its slope outward, and around
        sx = ray.x, sy = ray.y, ahead = ray.z;
    } else if (c.lens.kind != LensKind::pinhole) {
        float const u = sx, v = sy;
        splat::detail::unbend<OneFloat>(c.lens, u, v, sx, sy);
        splat::detail::BentSlopes<OneFloat> const at(c.lens, sx, sy);
        size = size / std::sqrt(multiply_add(at.d00, at.d11, -(at.d01 * at.d01)));
    }
    float const view[3] = {sx * depth, sy * depth, ahead * depth};
    float const log_scale = logarithm(size);
    Gaussian g{};
    for (std::uint32_t i = 0; i < 3; ++i) {
        float const across = multiply_add(c.rotation[0][i], view[0], c.rotation[1][i] * view[1]);
        g.mean_world[i] = c.position[i] + multiply_add(c.rotation[2][i], view[2], across);
        g.colour[i] = of.rgb[i] > 0 ? of.rgb[i] / n : 0.0f;
        g.log_scale[i] = log_scale;
    }
    g.opacity = r.opacity;
    g.rotation[0] = 1;
    g.id = id_of_cell(keyframe, row * grid.columns + column);
    return g;
}

/// Does the map lose this Gaussian? A record that is not finite goes, too.
inline bool is_removed(Gaussian const& g, RemoveRules const& r, float scene_depth) noexcept
{
    float const most = logarithm(r.most_scale * scene_depth);
    bool stays = g.opacity >= r.least_opacity;
    for (std::uint32_t i = 0; i < 3; ++i)
        stays = stays && g.log_scale[i] <= most && g.log_scale[i] > -1e18f && g.mean_world[i] > -1e18f && g.mean_world[i] < 1e18f;
    return !stays;
}

}}} // namespace tilemesh::splat::map
TILEMESH_EXACT_END
