#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <tilemesh/joined_threads.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/splat/lens_point.hpp>
#include <tilemesh/splat/rules.hpp>
#include <tilemesh/splat/view.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

namespace detail {

using Vector = std::array<double, 3>;
inline double dot(Vector const& a, Vector const& b) noexcept { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vector cross(Vector const& a, Vector const& b) noexcept
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// A Gaussian before rays, in view space: `whitening` takes space to units of its standard deviations, and `mean` is its mean there.
struct RayGaussian {
    Matrix3 whitening;           ///< lower triangular
    Vector place;                ///< the mean, in view space
    Vector mean;                 ///< whitened: a ray whose product with it is positive there comes nearest to the mean in front of the camera
    Vector direction;            ///< of the mean, in view space
    double sine, cosine;         ///< of the cone around `direction` that holds all rays with an alpha of alpha_min or more
    double depth, opacity, most; ///< `most`: the square of the response's radius, in standard deviations, where alpha is alpha_min
    std::array<double, 3> colour;
    splat::GaussianId id;
};

/// The inverse of the Cholesky factor of a covariance; false if that is not positive definite.
inline bool whiten(Matrix3 const& s, Matrix3& to) noexcept
{
    double const a = std::sqrt(s[0][0]), b = s[1][0] / a, c = s[2][0] / a, d = std::sqrt(s[1][1] - b * b), e = (s[2][1] - b * c) / d;
    double const f = std::sqrt(s[2][2] - c * c - e * e);
    if (!(a > 0 && d > 0 && f > 0)) return false;
    to = {{{1 / a, 0, 0}, {-b / (a * d), 1 / d, 0}, {(b * e - c * d) / (a * d * f), -e / (d * f), 1 / f}}};
    return true;
}
inline Vector times(Matrix3 const& m, Vector const& v) noexcept
{
    return {dot(m[0], v), dot(m[1], v), dot(m[2], v)};
}

/// The Gaussian before the rays of a camera whose lens has its limit; false if it has no place in the picture.
template <class Record>
bool before_rays(Record const& g, splat::Camera const& camera, splat::Rules const& rules, double alpha_min, RayGaussian& out)
{
    if (!(double{g.opacity} > alpha_min)) return false;
    Matrix3 to_view{};
    Vector p{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            to_view[i][j] = camera.rotation[i][j];
            p[i] += to_view[i][j] * (double{g.mean_world[j]} - camera.position[j]);
        }
    // With a rolling shutter, the picture's dilation and the depth are those of the mean's own row.
    double const first[3] = {p[0], p[1], p[2]};
    double at[3] = {p[0], p[1], p[2]}, row = 0;
    bool const rolls = camera.shutter.rolls();
    if (rolls) row = splat::row_of_point<double>(camera, first), splat::RowPose<double>(camera.shutter, row).seen(first, at);
    auto point = splat::through_lens<double>(camera, at);
    if (!point.seen || !(point.depth > camera.near_depth)) return false;
    if (rolls) {
        splat::shear_by_rows<double>(camera, row, at, point.by);
        splat::RowPose<double> const pose(camera.shutter, row); // covectors of the row's axes, in those of row 0
        for (auto& by : point.by) {
            double const own[3] = {by[0], by[1], by[2]};
            for (int j = 0; j < 3; ++j) by[j] = own[0] * pose.turn[0][j] + own[1] * pose.turn[1][j] + own[2] * pose.turn[2][j];
        }
    }
    double largest = 0;
    for (float const s : g.log_scale) largest = std::max(largest, std::exp(double{s}));
    Matrix3 scale{};
    for (std::size_t i = 0; i < 3; ++i) scale[i][i] = std::max(std::exp(double{g.log_scale[i]}), 1e-6 * largest); // a disc's thickness
    auto const axes = to_view * rotation_of(g.rotation) * scale;
    auto covariance = axes * transpose(axes);
    // The picture's dilation, in space: h B B^T, with the pseudo-inverse B of the lens's Jacobian.
    Vector const j1{point.by[0][0], point.by[0][1], point.by[0][2]}, j2{point.by[1][0], point.by[1][1], point.by[1][2]};
    double const a = dot(j1, j1), b = dot(j1, j2), c = dot(j2, j2), determinant = a * c - b * b;
    double opacity = double{g.opacity};
    if (rules.coverage == splat::Coverage::preserved) { // as in splat::project: of the conic in the picture
        auto const to = transpose(axes);
        Vector const v1 = times(to, j1), v2 = times(to, j2), minor = cross(v1, v2);
        double const h = double{rules.dilation}, sharp = dot(minor, minor), wide = sharp + h * (dot(v1, v1) + dot(v2, v2)) + h * h;
        opacity = std::min(opacity, 1.0) * std::sqrt(std::max(sharp / wide, 0.000025));
        if (!(opacity > alpha_min)) return false;
    }
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            auto const one = [&](std::size_t k) { return (j1[k] * c - j2[k] * b) / determinant; };
            auto const two = [&](std::size_t k) { return (j2[k] * a - j1[k] * b) / determinant; };
            covariance[i][j] += double{rules.dilation} * (one(i) * one(j) + two(i) * two(j));
        }
    if (!whiten(covariance, out.whitening)) return false;
    out.place = p;
    out.mean = times(out.whitening, p);
    out.most = 2 * std::log(opacity / alpha_min);
    // The Gaussian's ellipsoid lies in a ball of this radius: the largest eigenvalue of a covariance is below its trace.
    auto const& move = camera.shutter.move;
    // Other rows stand elsewhere.
    double const moves = rolls ? camera.shutter.reach * std::hypot(double{move[0]}, double{move[1]}, double{move[2]}) : 0;
    double const radius = std::sqrt(out.most * (covariance[0][0] + covariance[1][1] + covariance[2][2])) + moves;
    double const distance = std::sqrt(dot(p, p));
    out.direction = {p[0] / distance, p[1] / distance, p[2] / distance};
    out.sine = radius < distance ? radius / distance : 1;
    out.cosine = radius < distance ? std::sqrt(1 - out.sine * out.sine) : -1; // the camera may be in the ball: any ray
    out.depth = point.depth, out.opacity = opacity, out.colour = colour_seen(g, camera), out.id = g.id;
    return std::isfinite(out.depth + out.most + dot(out.mean, out.mean));
}

} // namespace detail

/// The picture of exact rays, in double: a term's alpha is the largest that its Gaussian has anywhere along the pixel's ray, opacity exp(-m^2 / 2)
/// with m the distance of the ray from the mean in standard deviations. No Jacobian is in it but for the picture's dilation. It judges
/// the conic that the kernels blend: for lenses that bend, and for Gaussians that are large and near. It has the order and the
/// cut-offs of `rules` (alpha_min on each pixel, alpha_max, the stop), and no footprint. A pixel without a ray is NaN. `depth`, if it is not null,
/// gets the mean depth of what covers a pixel, weighted by what each term adds; 0 where at most half of it is covered.
///
/// `gaussians`: a range of records of any degree. Cost: about 50 flops for each pixel and each Gaussian whose ball may reach its block
/// of 16 x 16 pixels; seconds for a map of 30,000 at 640 x 480.
template <class Records = std::span<splat::Gaussian const>>
Image render_exact_rays(Records const& gaussians, splat::Camera const& camera_of_file, splat::Rules const& rules, unsigned threads = 1,
                        Plane* depth = nullptr)
{
    using namespace detail;
    auto const camera = splat::make_view(camera_of_file, rules).camera;
    std::vector<RayGaussian> seen;
    double const alpha_min = std::max(double{rules.alpha_min}, 1e-12);
    for (auto const& g : gaussians)
        if (RayGaussian one; before_rays(g, camera, rules, alpha_min, one)) seen.push_back(one);
    std::stable_sort(seen.begin(), seen.end(), [](auto const& a, auto const& b) { return a.depth != b.depth ? a.depth < b.depth : a.id < b.id; });

    Image picture(camera.width, camera.height);
    if (depth != nullptr) *depth = Plane(camera.width, camera.height);
    constexpr std::uint32_t side = 16;
    std::uint32_t const across = (camera.width + side - 1) / side, blocks = across * ((camera.height + side - 1) / side);
    auto const blend_block = [&](std::uint32_t block) {
        std::uint32_t const x0 = block % across * side, y0 = block / across * side;
        std::uint32_t const x1 = std::min(x0 + side, camera.width), y1 = std::min(y0 + side, camera.height);
        std::array<Vector, side * side> rays;
        Vector axis{};
        std::size_t n = 0;
        std::array<Vector, side> from{}; // where a row's camera stands, in view space
        for (std::uint32_t y = y0; y < y1; ++y)
            for (std::uint32_t x = x0; x < x1; ++x, ++n) {
                double d[3];
                rays[n] = {};
                if (!splat::ray_of<double>(camera, x + 0.5 - camera.cx, y + 0.5 - camera.cy, d)) continue;
                if (camera.shutter.rolls()) {
                    splat::RowPose<double> const row(camera.shutter, (y + 0.5 - camera.cy) / camera.fy);
                    double const own[3] = {d[0], d[1], d[2]};
                    for (std::size_t k = 0; k < 3; ++k) {
                        d[k] = row.turn[0][k] * own[0] + row.turn[1][k] * own[1] + row.turn[2][k] * own[2];
                        from[y - y0][k] = row.place[k];
                    }
                }
                double const size = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
                for (std::size_t k = 0; k < 3; ++k) rays[n][k] = d[k] / size, axis[k] += rays[n][k];
            }
        double const size = std::sqrt(dot(axis, axis));
        double cosine = 1; // of the cone that holds the block's rays
        for (auto& v : axis) v /= size;
        for (std::size_t i = 0; i < n; ++i)
            if (dot(rays[i], rays[i]) > 0) cosine = std::min(cosine, dot(rays[i], axis));
        double const sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
        std::vector<std::size_t> list;
        for (std::size_t i = 0; i < seen.size(); ++i) {
            // Both cones meet unless the axes are farther apart than the sum of their angles, which is below 180 degrees.
            auto const& g = seen[i];
            bool const wide = g.cosine < 0 || cosine < 0;
            if (wide || dot(g.direction, axis) >= cosine * g.cosine - sine * g.sine - 1e-9) list.push_back(i);
        }
        n = 0;
        for (std::uint32_t y = y0; y < y1; ++y)
            for (std::uint32_t x = x0; x < x1; ++x, ++n) {
                auto const& ray = rays[n];
                float* const to = &picture.rgb[3 * (std::size_t{y} * camera.width + x)];
                if (!(dot(ray, ray) > 0)) {
                    for (int k = 0; k < 3; ++k) to[k] = std::numeric_limits<float>::quiet_NaN();
                    continue;
                }
                double left = 1, sum[3] = {0, 0, 0}, deep = 0;
                for (std::size_t const i : list) {
                    auto const& g = seen[i];
                    auto mean = g.mean;
                    if (camera.shutter.rolls()) {
                        auto const& c = from[y - y0];
                        mean = times(g.whitening, {g.place[0] - c[0], g.place[1] - c[1], g.place[2] - c[2]});
                    }
                    auto const d = times(g.whitening, ray);
                    if (!(dot(mean, d) > 0)) continue; // the nearest point is behind the camera
                    auto const away = cross(mean, d);
                    double const squared = dot(away, away) / dot(d, d);
                    if (!(squared <= g.most)) continue;
                    double const alpha = std::min(g.opacity * std::exp(-0.5 * squared), double{rules.alpha_max});
                    double const after = left * (1 - alpha);
                    if (rules.stop == splat::Stop::before_crossing && after < double{rules.transmittance_min}) break;
                    for (std::size_t k = 0; k < 3; ++k) sum[k] += left * alpha * g.colour[k];
                    deep += left * alpha * g.depth;
                    left = after;
                    if (left < double{rules.transmittance_min}) break;
                }
                for (std::size_t k = 0; k < 3; ++k) to[k] = static_cast<float>(sum[k] + left * double{rules.background[k]});
                if (depth != nullptr && left < 0.5) depth->values[std::size_t{y} * camera.width + x] = static_cast<float>(deep / (1 - left));
            }
    };
    auto const some = [&](std::uint32_t first) {
        for (std::uint32_t block = first; block < blocks; block += std::max(1u, threads)) blend_block(block);
    };
    JoinedThreads workers;
    for (std::uint32_t t = 1; t < threads; ++t) workers.start(some, t);
    some(0);
    workers.join();
    return picture;
}

}}} // namespace tilemesh::report
