// The picture of 3D Gaussian Splatting's rasteriser (Kerbl et al. 2023), step by step in double. It shares no function with the kernels or
// with report/reference_double.hpp.
#pragma once
#include "pose_reference.hpp"

namespace support {

/// What the rasteriser keeps of a Gaussian after its first pass.
struct RasterisedSplat {
    double x, y;                      ///< of the mean; the middle of the first pixel is (0, 0)
    double conic[3];                  ///< xx, xy, yy of the inverse covariance
    double opacity, depth;
    std::array<double, 3> colour;
    int first_x, end_x, first_y, end_y; ///< tiles of 16 x 16 pixels
    std::uint32_t id;
};

/// The tiles [first, end) that a square touches along an axis of `tiles` tiles. Casts to int cut off the fraction.
inline std::array<int, 2> tiles_touched(double middle, int radius, int tiles)
{
    auto const clamped = [&](int tile) { return std::min(tiles, std::max(0, tile)); };
    return {clamped(static_cast<int>((middle - radius) / 16)), clamped(static_cast<int>((middle + radius + 16 - 1) / 16))};
}

/// `gaussians` with the picture's colours; `background` is linear RGB. Returns three doubles a pixel.
inline std::vector<double> rasterised(std::span<tilemesh::splat::Gaussian const> gaussians, tilemesh::splat::Camera const& camera,
                                      std::array<float, 3> const& background)
{
    int const width = static_cast<int>(camera.width), height = static_cast<int>(camera.height);
    int const columns = (width + 15) / 16, rows = (height + 15) / 16;
    tilemesh::splat::Rules rules;
    rules.dilation = 0.3f, rules.alpha_min = 0;
    auto view = pose::camera_of(camera, rules); // whose slopes are bounded by the half width, and whose near plane is fixed
    view.limit_x = double{1.3f} * width / (2.0 * camera.fx), view.limit_y = double{1.3f} * height / (2.0 * camera.fy), view.near_depth = 0.2f;

    std::vector<RasterisedSplat> splats;
    for (auto const& g : gaussians) {
        pose::Splat p;
        if (!pose::project(g, view, rules, p) || p.d == 0) continue;
        double const a = p.a, b = p.b, c = p.c, determinant = p.d;
        double const middle = 0.5 * (a + c), apart = std::sqrt(std::max(0.1, middle * middle - determinant));
        int const radius = static_cast<int>(std::ceil(3 * std::sqrt(std::max(middle + apart, middle - apart))));
        double const px = p.u + camera.cx - 0.5, py = p.v + camera.cy - 0.5;
        auto const across = tiles_touched(px, radius, columns), down = tiles_touched(py, radius, rows);
        if ((across[1] - across[0]) * (down[1] - down[0]) == 0) continue;
        RasterisedSplat s{px,
                          py,
                          {c / determinant, -b / determinant, a / determinant},
                          g.opacity,
                          p.z,
                          {},
                          across[0],
                          across[1],
                          down[0],
                          down[1],
                          static_cast<std::uint32_t>(g.id)};
        for (std::size_t i = 0; i < 3; ++i) s.colour[i] = std::max(double{g.colour[i]}, 0.0);
        splats.push_back(s);
    }

    std::vector<double> picture(std::size_t{3} * camera.width * camera.height);
    for (int tile_y = 0; tile_y < rows; ++tile_y)
        for (int tile_x = 0; tile_x < columns; ++tile_x) {
            std::vector<RasterisedSplat const*> list;
            for (auto const& s : splats)
                if (tile_x >= s.first_x && tile_x < s.end_x && tile_y >= s.first_y && tile_y < s.end_y) list.push_back(&s);
            std::sort(list.begin(), list.end(),
                      [](auto const* m, auto const* n) { return m->depth != n->depth ? m->depth < n->depth : m->id < n->id; });
            for (int py = 16 * tile_y; py < std::min(16 * tile_y + 16, height); ++py)
                for (int px = 16 * tile_x; px < std::min(16 * tile_x + 16, width); ++px) {
                    double through = 1, colour[3] = {0, 0, 0};
                    for (auto const* s : list) {
                        double const dx = s->x - px, dy = s->y - py;
                        double const power = -0.5 * (s->conic[0] * dx * dx + s->conic[2] * dy * dy) - s->conic[1] * dx * dy;
                        if (power > 0) continue;
                        double const alpha = std::min(double{0.99f}, s->opacity * std::exp(power));
                        if (alpha < double{1.0f / 255.0f}) continue;
                        double const left = through * (1 - alpha);
                        if (left < double{0.0001f}) break;
                        for (std::size_t i = 0; i < 3; ++i) colour[i] += s->colour[i] * alpha * through;
                        through = left;
                    }
                    auto const at = 3 * (static_cast<std::size_t>(py) * camera.width + static_cast<std::size_t>(px));
                    for (std::size_t i = 0; i < 3; ++i) picture[at + i] = colour[i] + through * double{background[i]};
                }
        }
    return picture;
}

} // namespace support
