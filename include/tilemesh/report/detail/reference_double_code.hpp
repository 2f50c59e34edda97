#pragma once
#include <tilemesh/report/reference_double.hpp>
#include <tilemesh/splat/camera.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST CutOffs cut_offs(splat::Rules const& rules) noexcept
{
    return {double{rules.alpha_min}, double{rules.alpha_max}, double{rules.transmittance_min},
            rules.footprint, 0.0, rules.stop == splat::Stop::after_crossing};
}

TILEMESH_HOST CutOffs no_cut_offs(double skip_below) noexcept
{
    return {skip_below > 0.0 ? skip_below : 0.0, 1.0, 0.0, splat::Footprint::opacity_box};
}

namespace detail {

TILEMESH_HOST Matrix3 operator*(Matrix3 const& a, Matrix3 const& b)
{
    Matrix3 product{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            for (std::size_t k = 0; k < 3; ++k) product[i][j] += a[i][k] * b[k][j];
    return product;
}

TILEMESH_HOST Matrix3 transpose(Matrix3 const& m)
{
    return {{{m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]}, {m[0][2], m[1][2], m[2][2]}}};
}

TILEMESH_HOST Matrix3 rotation_of(float const (&quaternion)[4])
{
    double const length = std::sqrt(double{quaternion[0]} * quaternion[0] + double{quaternion[1]} * quaternion[1] +
                                    double{quaternion[2]} * quaternion[2] + double{quaternion[3]} * quaternion[3]);
    double const w = quaternion[0] / length;
    double const x = quaternion[1] / length;
    double const y = quaternion[2] / length;
    double const z = quaternion[3] / length;
    return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
             {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
             {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

TILEMESH_HOST double harmonic(int l, int m, double x, double y, double z)
{
    int const order = std::abs(m);
    double const radius = std::hypot(x, y);
    double const phi = radius > 0.0 ? std::atan2(y, x) : 0.0;
    double const sign = order % 2 != 0 ? -1.0 : 1.0;
    double const pi = 3.14159265358979323846;
    double factorials = 1.0; // (l - |m|)! / (l + |m|)!
    for (int i = l - order + 1; i <= l + order; ++i) factorials /= i;
    double legendre = 1.0; // P_m^m, then upwards in l
    for (int i = 1; i <= order; ++i) legendre *= (2.0 * i - 1.0) * radius;
    double previous = 0.0;
    for (int i = order + 1; i <= l; ++i) {
        double const next = ((2.0 * i - 1.0) * z * legendre - (i + order - 1.0) * previous) / (i - order);
        previous = legendre;
        legendre = next;
    }
    double const norm = std::sqrt((2.0 * l + 1.0) / (4.0 * pi) * factorials);
    if (m == 0) return norm * legendre;
    return sign * std::sqrt(2.0) * norm * legendre * (m > 0 ? std::cos(order * phi) : std::sin(order * phi));
}

TILEMESH_HOST ReferenceSpan span_of_tiles(double mean, double radius)
{
    double const middle = mean - 0.5;
    return {16.0 * std::floor((middle - radius) / 16.0), 16.0 * std::floor((middle + radius + 15.0) / 16.0) - 1.0};
}

TILEMESH_HOST ReferenceSpan span_of_box(double mean, double half)
{
    return {std::floor(mean - half), std::floor(mean + half)};
}

TILEMESH_HOST ReferenceSpan common(ReferenceSpan const& a, ReferenceSpan const& b)
{
    return {std::max(a.first, b.first), std::min(a.last, b.last)};
}

TILEMESH_HOST void blend_reference_rows(std::span<ReferenceSplat const> nearest_first, std::uint32_t begin, std::uint32_t end, std::uint32_t width,
                                        CutOffs const& cuts, std::span<double> rgb, std::span<double> transmittance) noexcept
{
    for (auto const& splat : nearest_first)
        for (auto y = std::max(begin, splat.first_y); y < end && y <= splat.last_y; ++y)
            for (auto x = splat.first_x; x <= splat.last_x; ++x) {
                auto const pixel = std::size_t{y} * width + x;
                auto& through = transmittance[pixel];
                if (through < cuts.transmittance_min) continue;
                double const dx = x + 0.5 - splat.mean_x;
                double const dy = y + 0.5 - splat.mean_y;
                double const power = -0.5 * (splat.conic_xx * dx * dx + splat.conic_yy * dy * dy) - splat.conic_xy * dx * dy;
                // Rounding can make the form positive if the ellipse is a needle.
                double alpha = splat.opacity * std::exp(std::min(power, 0.0));
                if (alpha < cuts.alpha_min) continue;
                alpha = std::min(alpha, cuts.alpha_max);
                double const behind = through * (1.0 - alpha);
                if (!cuts.blends_crossing && behind < cuts.transmittance_min) {
                    through = -through; // below any limit
                    continue;
                }
                for (std::size_t i = 0; i < 3; ++i) rgb[3 * pixel + i] += through * alpha * splat.colour[i];
                through = behind;
            }
}

} // namespace detail
}}} // namespace tilemesh::report
