#pragma once
#include "support.hpp"

// The largest difference of the two arithmetics of compositing, derived from their roundings alone. It is valid for any map.
namespace support {

/// The largest relative difference of alpha between fast and precise arithmetic, for a splat at a pixel. `off0` and `off` are the distances
/// across the splat at the first row of the pixel's cell and at the pixel, k rows below. dx is the same in both.
///
/// Each rounding is u = 2^-24. A power is a sum of terms; its rounding error is u of each term (S, S0: the terms at both rows), a few
/// times, and e^power has this error relatively. The distances are rounded as their term y; this matters for steep needles. Fast
/// arithmetic: alpha = 2^p0 (2^rise)^k q^(k (k - 1) / 2). That is at most 7 exponentials (each a polynomial with an error of
/// 7.5e-8 and two roundings: 4 u), 7 products, 3 times the rounding of q's exponent, and k times the rounding of the rise. The opacity is a
/// term of the power, log2(opacity), whose roundings count as those of four exponentials.
inline double alpha_rounding(splat::Splat const& s, double dx, double off0, double off, double y0, double y, int k)
{
    constexpr double u = 0x1p-24;
    double const along = std::fabs(double{s.along}), across = std::fabs(double{s.across});
    double const terms0 = along * dx * dx + across * off0 * off0, terms = along * dx * dx + across * off * off;
    double const exponentials = 11 * 4 + 11 + 5; // 5: precise's exponential and its product
    double const powers = 6 * (terms0 + terms) + 24 * across + 4 * k * (2 * across * std::fabs(off0) + across);
    double const distances = 2 * across * std::fabs(off) * (std::fabs(y0) + std::fabs(y));
    return u * (exponentials + powers + distances);
}

/// The largest difference between fast and precise arithmetic for each pixel, row by row, if no pixel stops.
///
/// Let a be the alphas of precise arithmetic and b those of fast. Exchanging one after the other, from the last to the first,
///   C(b) - C(a) = sum of (b_i - a_i) T_i (c_i - B_i),
/// where T_i is the transmittance before pair i (of a) and B_i the colour composed behind it (of b). Both c_i and B_i lie in [0,
/// brightest]. If both draw the pair, |b_i - a_i| T_i is the relative error times the weight w_i, and the weights sum up to at most 1. If
/// alpha is nearer to alpha_min than its error, one of the two may leave the pair out: alpha T_i. Each pair also rounds the transmittance
/// once and the colour once, in both: 2^-23 of `brightest` in all.
inline std::vector<double> limits_of_fast(std::vector<splat::Gaussian> const& gaussians, splat::Camera const& camera,
                                          splat::Rules const& rules)
{
    std::vector<double> limits(std::size_t{camera.width} * camera.height, 0), transmittance(limits.size(), 1);
    double brightest = 0;
    for (auto const& s : sorted_splats(gaussians, splat::make_view(camera, rules))) {
        for (float c : s.colour) brightest = std::max(brightest, double{c});
        auto const r = s.rect();
        for (auto y = r.y0; y < r.y1; ++y)
            for (auto x = r.x0; x < r.x1; ++x) {
                auto const k = y % splat::cell_height;
                float const px = static_cast<float>(x) + 0.5f - camera.cx, py = static_cast<float>(y) + 0.5f - camera.cy;
                double const dx = px - s.mean_px[0], dy = py - s.mean_px[1], off = dy - double{s.slope} * dx;
                double const error = alpha_rounding(s, dx, off - k, off, dy - k, dy, static_cast<int>(k));
                double const alpha = std::min(splat::alpha_at(s, px, py), rules.alpha_max);
                if (alpha < rules.alpha_min * (1 - 1.01 * error)) continue;
                auto const i = std::size_t{y} * camera.width + x;
                bool const either = alpha <= rules.alpha_min * (1 + 1.01 * error);
                limits[i] += alpha * transmittance[i] * (either ? 1 + error : error) + 0x1p-23;
                if (alpha >= rules.alpha_min) transmittance[i] -= alpha * transmittance[i];
            }
    }
    for (double& limit : limits) limit *= brightest;
    return limits;
}

} // namespace support
