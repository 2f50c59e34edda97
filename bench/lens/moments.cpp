#include "tables.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/splat/lens_point.hpp>
#include <tilemesh/splat/view.hpp>

using tilemesh::report::detail::operator*;

namespace {

using Vector = std::array<double, 3>;

double p99(std::vector<double>& values)
{
    if (values.empty()) return 0;
    auto const at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 99 / 100);
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

} // namespace

Moments sample_moments(std::vector<tilemesh::splat::Gaussian> const& gaussians, tilemesh::splat::Camera const& camera_of_file, std::uint32_t samples)
{
    using namespace tilemesh;
    auto const camera = splat::make_view(camera_of_file, {}).camera;
    std::mt19937_64 bits(7);
    std::normal_distribution<double> normal;
    std::vector<Vector> points(samples / 2); // the same for all Gaussians: with covariance 1 in all directions
    for (auto& p : points)
        for (double& v : p) v = normal(bits);
    double second[3][3] = {};
    for (auto const& p : points)
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k)
                second[i][k] += p[static_cast<std::size_t>(i)] * p[static_cast<std::size_t>(k)] / static_cast<double>(points.size());
    // Whitened by the inverse of the Cholesky factor of their own covariance.
    double l[3][3] = {};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k <= i; ++k) {
            double sum = second[i][k];
            for (int j = 0; j < k; ++j) sum -= l[i][j] * l[k][j];
            l[i][k] = i == k ? std::sqrt(sum) : sum / l[k][k];
        }
    for (auto& p : points) {
        p[0] /= l[0][0];
        p[1] = (p[1] - l[1][0] * p[0]) / l[1][1];
        p[2] = (p[2] - l[2][0] * p[0] - l[2][1] * p[1]) / l[2][2];
    }

    std::vector<double> centres, covariances;
    for (auto const& g : gaussians) {
        report::detail::Matrix3 to_view{}, scale{};
        Vector mean{};
        for (std::size_t i = 0; i < 3; ++i) {
            scale[i][i] = std::exp(double{g.log_scale[i]});
            for (std::size_t k = 0; k < 3; ++k) {
                to_view[i][k] = camera.rotation[i][k];
                mean[i] += to_view[i][k] * (double{g.mean_world[k]} - double{camera.position[k]});
            }
        }
        double const p[3] = {mean[0], mean[1], mean[2]};
        auto const j = splat::through_lens<double>(camera, p);
        if (!j.seen || !(j.depth > double{camera.near_depth})) continue;
        double const x = j.at[0] + double{camera.cx}, y = j.at[1] + double{camera.cy};
        if (!(x >= 0 && x < camera.width && y >= 0 && y < camera.height)) continue;
        auto const axes = to_view * report::detail::rotation_of(g.rotation) * scale;
        double row[2][3] = {}, a = 0, b = 0, c = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            for (int i = 0; i < 2; ++i) row[i][k] = j.by[i][0] * axes[0][k] + j.by[i][1] * axes[1][k] + j.by[i][2] * axes[2][k];
            a += row[0][k] * row[0][k], b += row[0][k] * row[1][k], c += row[1][k] * row[1][k];
        }
        if (!(a > 1e-4 && a * c - b * b > 1e-8 * a * c && a < 22'500)) continue; // from .01 to 150 pixels, and no line
        double u = 0, v = 0, uu = 0, uv = 0, vv = 0, n = 0;
        for (auto const& s : points)
            for (double const sign : {1.0, -1.0}) {
                double q[3];
                for (std::size_t i = 0; i < 3; ++i) q[i] = mean[i] + sign * (axes[i][0] * s[0] + axes[i][1] * s[1] + axes[i][2] * s[2]);
                auto const at = splat::through_lens<double>(camera, q);
                if (!at.seen) continue;
                double const du = at.at[0] - j.at[0], dv = at.at[1] - j.at[1];
                u += du, v += dv, uu += du * du, uv += du * dv, vv += dv * dv, ++n;
            }
        if (n < static_cast<double>(points.size())) continue;
        u /= n, v /= n, uu = uu / n - u * u, uv = uv / n - u * v, vv = vv / n - v * v;
        centres.push_back(std::hypot(u, v));
        double const l1 = std::sqrt(a), l2 = b / l1, l3 = std::sqrt(c - l2 * l2); // J's covariance is L L^T
        double const m1 = uu / a - 1, m2 = (uv / l1 - uu * l2 / a) / l3, m3 = (vv - 2 * l2 * uv / l1 + l2 * l2 * uu / a) / (l3 * l3) - 1;
        covariances.push_back(std::sqrt(m1 * m1 + 2 * m2 * m2 + m3 * m3));
    }
    return {centres.size(), p99(centres), p99(covariances)};
}
