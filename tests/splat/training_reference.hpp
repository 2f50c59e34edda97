// The picture of 3D Gaussian Splatting's rasteriser (Kerbl et al. 2023), step by step in double. It shares no function with the kernels or
// with report/reference_double.hpp.
#pragma once
#include "../standard.hpp"
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/gaussian.hpp>

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
    double const tan_x = width / (2.0 * camera.fx), tan_y = height / (2.0 * camera.fy);

    std::vector<RasterisedSplat> splats;
    for (auto const& g : gaussians) {
        double t[3]; // the mean in view space
        for (int i = 0; i < 3; ++i) {
            t[i] = 0;
            for (int j = 0; j < 3; ++j) t[i] += double{camera.rotation[i][j]} * (double{g.mean_world[j]} - double{camera.position[j]});
        }
        if (t[2] <= double{0.2f}) continue;

        // The covariance M^T M with M = S R^T, from a unit quaternion.
        double q[4], length = 0;
        for (int i = 0; i < 4; ++i) length += double{g.rotation[i]} * g.rotation[i];
        for (int i = 0; i < 4; ++i) q[i] = g.rotation[i] / std::sqrt(length);
        double const r = q[0], x = q[1], y = q[2], z = q[3];
        double const turn[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - r * z), 2 * (x * z + r * y)},
                                   {2 * (x * y + r * z), 1 - 2 * (x * x + z * z), 2 * (y * z - r * x)},
                                   {2 * (x * z - r * y), 2 * (y * z + r * x), 1 - 2 * (x * x + y * y)}};
        double sigma[3][3] = {};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                for (int k = 0; k < 3; ++k) sigma[i][j] += turn[i][k] * turn[j][k] * std::exp(2 * double{g.log_scale[k]});

        // Its projection, with clamped slopes, and the dilation.
        double const most_x = double{1.3f} * tan_x, most_y = double{1.3f} * tan_y;
        double const u = std::min(most_x, std::max(-most_x, t[0] / t[2])) * t[2];
        double const v = std::min(most_y, std::max(-most_y, t[1] / t[2])) * t[2];
        double to_screen[2][3];
        for (int j = 0; j < 3; ++j) {
            to_screen[0][j] = camera.fx / t[2] * camera.rotation[0][j] - camera.fx * u / (t[2] * t[2]) * camera.rotation[2][j];
            to_screen[1][j] = camera.fy / t[2] * camera.rotation[1][j] - camera.fy * v / (t[2] * t[2]) * camera.rotation[2][j];
        }
        double covariance[2][2] = {};
        for (int a = 0; a < 2; ++a)
            for (int b = 0; b < 2; ++b)
                for (int i = 0; i < 3; ++i)
                    for (int j = 0; j < 3; ++j) covariance[a][b] += to_screen[a][i] * sigma[i][j] * to_screen[b][j];
        double const a = covariance[0][0] + 0.3f, b = covariance[0][1], c = covariance[1][1] + 0.3f;
        double const determinant = a * c - b * b;
        if (determinant == 0) continue;

        double const middle = 0.5 * (a + c), apart = std::sqrt(std::max(0.1, middle * middle - determinant));
        int const radius = static_cast<int>(std::ceil(3 * std::sqrt(std::max(middle + apart, middle - apart))));
        double const px = camera.fx * t[0] / t[2] + camera.cx - 0.5, py = camera.fy * t[1] / t[2] + camera.cy - 0.5;
        auto const across = tiles_touched(px, radius, columns), down = tiles_touched(py, radius, rows);
        if ((across[1] - across[0]) * (down[1] - down[0]) == 0) continue;
        RasterisedSplat s{px,        py,        {c / determinant, -b / determinant, a / determinant}, g.opacity, t[2], {}, across[0],
                          across[1], down[0], down[1],   static_cast<std::uint32_t>(g.id)};
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
