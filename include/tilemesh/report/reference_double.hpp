#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>
#include <tilemesh/config.hpp>
#include <tilemesh/joined_threads.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/splat/lens_point.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <tilemesh/splat/rules.hpp>
#include <tilemesh/splat/view.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// Whether a reference applies the cut-offs of the model. `none` gives R0, the picture of the formula. `same` gives R1, the picture with
/// the model's cut-offs. R1 - R0 is the error of the cut-offs, and a kernel's picture - R1 is the error of its rounding.
enum class Cuts {
    none, ///< no alpha_min, no alpha_max, no stop, no footprint
    same  ///< alpha_min, alpha_max, the stop at transmittance_min and the footprint
};

/// The cut-offs of a reference, in double. `cut_offs` returns those of a model, `no_cut_offs` returns none. To measure the cost of one
/// cut-off, start from either and change it.
///
/// No limit may be negative, and `transmittance_min` is at most 1.
struct CutOffs {
    double alpha_min;           ///< a term with a smaller alpha is skipped; 0: no term is skipped
    double alpha_max;           ///< alpha is clamped to this value; 1: no clamp
    double transmittance_min;   ///< a pixel is finished once its transmittance is below; 0: never
    splat::Footprint footprint; ///< `three_sigma_tiles`: the 16 x 16 pixel tiles whole, without the box
    /// A limit in standard deviations along each axis of the screen, for any footprint: a pixel is not touched outside the box with the
    /// half-widths sigmas * sqrt(xx) and sigmas * sqrt(yy) of the dilated covariance. 0: no limit.
    double sigmas = 0.0;
    /// Whether a pixel blends the term that takes its transmittance below the limit. If false, the pixel leaves this term out and is
    /// finished: a later term adds nothing, even if it is faint. That is the rule of 3D Gaussian Splatting (Kerbl et al. 2023). It needs
    /// alpha_max = 0.99, because a layer of alpha 1 would always be left out.
    bool blends_crossing = true;
};

/// The cut-offs of the model: `Cuts::same`.
TILEMESH_HOST CutOffs cut_offs(splat::Rules const& rules) noexcept;

/// Only terms with an alpha below `skip_below` are skipped: `Cuts::none`. A negative value or NaN counts as 0.
TILEMESH_HOST CutOffs no_cut_offs(double skip_below = 1e-12) noexcept;

namespace detail {

using Matrix3 = std::array<std::array<double, 3>, 3>;

TILEMESH_HOST Matrix3 operator*(Matrix3 const& a, Matrix3 const& b);

TILEMESH_HOST Matrix3 transpose(Matrix3 const& m);

/// The rotation matrix of a quaternion w, x, y, z of any length except 0.
TILEMESH_HOST Matrix3 rotation_of(float const (&quaternion)[4]);

/// The real spherical harmonic of degree l and order m in the unit direction (x, y, z), with the Condon-Shortley sign, by its definition: K
/// P_l^|m|(z) times the cosine or sine of m phi.
TILEMESH_HOST double harmonic(int l, int m, double x, double y, double z);

/// The colour of a record as the camera sees it.
template <class Record>
std::array<double, 3> colour_seen(Record const& gaussian, splat::Camera const& camera)
{
    std::array<double, 3> colour{gaussian.colour[0], gaussian.colour[1], gaussian.colour[2]};
    if constexpr (Record::sh_degree > 0) {
        std::array<double, 3> d{};
        for (std::size_t i = 0; i < 3; ++i) d[i] = double{gaussian.mean_world[i]} - camera.position[i];
        double const length = std::hypot(d[0], d[1], d[2]);
        std::size_t k = 0;
        for (int l = 1; l <= static_cast<int>(Record::sh_degree); ++l)
            for (int m = -l; m <= l; ++m, ++k) {
                double const basis = harmonic(l, m, d[0] / length, d[1] / length, d[2] / length);
                for (std::size_t c = 0; c < 3; ++c) colour[c] += basis * double{gaussian.harmonics[3 * k + c]};
            }
        for (double& c : colour) c = std::isnan(c) ? c : std::max(c, 0.0);
    }
    return colour;
}

/// A projected Gaussian: the mean and the inclusive rectangle in pixels, and the conic in 1/pixel^2.
struct ReferenceSplat {
    double depth;
    splat::GaussianId id;
    double mean_x, mean_y;
    double conic_xx, conic_xy, conic_yy;
    double opacity;
    std::array<double, 3> colour;
    std::uint32_t first_x, last_x, first_y, last_y;
};

/// The pixels that a splat may touch along one axis, before the frame cuts them: the first and the last one.
struct ReferenceSpan {
    double first, last;
};
/// The pixels of the 16-pixel tiles that 3D Gaussian Splatting's rasteriser gives a splat to. It puts the middle of the first pixel at 0,
/// divides by 16 with 15 added at the end, and cuts off the fraction.
TILEMESH_HOST ReferenceSpan span_of_tiles(double mean, double radius);
TILEMESH_HOST ReferenceSpan span_of_box(double mean, double half);
TILEMESH_HOST ReferenceSpan common(ReferenceSpan const& a, ReferenceSpan const& b);

/// Projects a Gaussian onto the screen; empty if it cannot be seen. Of the model it uses the dilation, the Jacobian's limit and the near
/// plane.
template <class Record>
std::optional<ReferenceSplat> project_reference(Record const& gaussian, splat::Camera const& camera, splat::Rules const& rules, CutOffs const& cuts)
{
    // View space: R (p - c).
    Matrix3 world_to_view{};
    std::array<double, 3> view{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            world_to_view[i][j] = camera.rotation[i][j];
            view[i] += world_to_view[i][j] * (double{gaussian.mean_world[j]} - camera.position[j]);
        }
    bool const bends = camera.lens.kind != splat::LensKind::pinhole, rolls = camera.shutter.rolls();
    splat::LensPoint<double> point{};
    auto bounded = camera;
    splat::bound_lens(bounded);
    double row = 0;
    if (rolls) { // in the view space of the mean's own row
        double const first[3] = {view[0], view[1], view[2]};
        row = splat::row_of_point<double>(bounded, first);
        splat::RowPose<double> const pose(bounded.shutter, row);
        double own[3];
        pose.seen(first, own);
        Matrix3 turn{};
        for (std::size_t i = 0; i < 3; ++i) {
            view[i] = own[i];
            for (std::size_t j = 0; j < 3; ++j) turn[i][j] = pose.turn[i][j];
        }
        world_to_view = turn * world_to_view;
    }
    if (bends) {
        point = splat::through_lens<double>(bounded, {view[0], view[1], view[2]});
        if (!point.seen) return std::nullopt;
    }
    double const z = bends ? point.depth : view[2];
    if (!(z > (rules.near_plane == splat::NearPlane::fixed ? 0.2f : camera.near_depth))) return std::nullopt;

    // Covariance in world space: R S S^T R^T.
    Matrix3 scale{};
    for (std::size_t i = 0; i < 3; ++i) scale[i][i] = std::exp(double{gaussian.log_scale[i]});
    auto const rotation = rotation_of(gaussian.rotation);
    auto const sigma = rotation * scale * transpose(scale) * transpose(rotation);

    // Covariance on the screen: J W Sigma W^T J^T + dilation; the third row of J is not used.
    double slope_x = view[0] / z;
    double slope_y = view[1] / z;
    if (rules.jacobian_limit > 0.0f) {
        bool const trainers = rules.slope_border == splat::SlopeBorder::of_half_width;
        auto const bound = [&](double given, double centre, double size, double focal) {
            return given > 0 ? given : rules.jacobian_limit * (trainers ? size / 2 : std::max(centre, size - centre)) / focal;
        };
        double const limit_x = bound(rules.slope_limit[0], camera.cx, camera.width, camera.fx);
        double const limit_y = bound(rules.slope_limit[1], camera.cy, camera.height, camera.fy);
        slope_x = std::max(-limit_x, std::min(limit_x, slope_x));
        slope_y = std::max(-limit_y, std::min(limit_y, slope_y));
    }
    Matrix3 jacobian{{{camera.fx / z, 0.0, -camera.fx * slope_x / z}, {0.0, camera.fy / z, -camera.fy * slope_y / z}, {0.0, 0.0, 0.0}}};
    for (std::size_t i = 0; bends && i < 2; ++i)
        for (std::size_t j = 0; j < 3; ++j) jacobian[i][j] = point.by[i][j];
    if (rolls) {
        double by[2][3];
        for (std::size_t i = 0; i < 6; ++i) by[i / 3][i % 3] = jacobian[i / 3][i % 3];
        splat::shear_by_rows<double>(bounded, row, {view[0], view[1], view[2]}, by);
        for (std::size_t i = 0; i < 6; ++i) jacobian[i / 3][i % 3] = by[i / 3][i % 3];
    }
    auto const to_screen = jacobian * world_to_view;
    auto const covariance = to_screen * sigma * transpose(to_screen);
    double const xx = covariance[0][0] + rules.dilation;
    double const xy = covariance[0][1];
    double const yy = covariance[1][1] + rules.dilation;
    double const determinant = xx * yy - xy * xy;
    if (!(xx > 0.0 && yy > 0.0 && determinant > 0.0 && std::isfinite(determinant))) return std::nullopt;

    ReferenceSplat splat{};
    splat.depth = z;
    splat.id = gaussian.id;
    splat.mean_x = (bends ? point.at[0] : camera.fx * view[0] / z) + camera.cx;
    splat.mean_y = (bends ? point.at[1] : camera.fy * view[1] / z) + camera.cy;
    splat.conic_xx = yy / determinant;
    splat.conic_xy = -xy / determinant;
    splat.conic_yy = xx / determinant;
    splat.opacity = gaussian.opacity;
    if (rules.coverage == splat::Coverage::preserved) {
        double const sharp = covariance[0][0] * covariance[1][1] - xy * xy;
        splat.opacity = std::min(splat.opacity, 1.0) * std::sqrt(std::max(0.000025, sharp / determinant));
    }
    bool finite = std::isfinite(splat.mean_x) && std::isfinite(splat.mean_y) && std::isfinite(splat.opacity);
    splat.colour = colour_seen(gaussian, camera);
    for (std::size_t i = 0; i < 3; ++i) {
        finite = finite && std::isfinite(splat.colour[i]);
    }
    if (!finite || !(splat.opacity > cuts.alpha_min)) return std::nullopt;

    // The pixels that it may touch: the box around the ellipse alpha = alpha_min, the paper's square, or the rasteriser's tiles, limited to
    // `sigmas` standard deviations.
    ReferenceSpan columns{};
    ReferenceSpan rows{};
    if (cuts.footprint == splat::Footprint::three_sigma_square) {
        double const largest = (xx + yy) / 2.0 + std::hypot((xx - yy) / 2.0, xy);
        double const half = std::ceil(3.0 * std::sqrt(largest));
        columns = span_of_box(splat.mean_x, half);
        rows = span_of_box(splat.mean_y, half);
    } else if (cuts.footprint == splat::Footprint::three_sigma_tiles) {
        double const middle = (xx + yy) / 2.0;
        double const largest = middle + std::sqrt(std::max(0.1, middle * middle - determinant));
        double const radius = std::ceil(3.0 * std::sqrt(largest));
        columns = span_of_tiles(splat.mean_x, radius);
        rows = span_of_tiles(splat.mean_y, radius);
    } else {
        double const sigmas = std::sqrt(2.0 * std::log(splat.opacity / cuts.alpha_min));
        columns = span_of_box(splat.mean_x, sigmas * std::sqrt(xx));
        rows = span_of_box(splat.mean_y, sigmas * std::sqrt(yy));
    }
    if (cuts.sigmas > 0.0) {
        columns = common(columns, span_of_box(splat.mean_x, cuts.sigmas * std::sqrt(xx)));
        rows = common(rows, span_of_box(splat.mean_y, cuts.sigmas * std::sqrt(yy)));
    }
    double const left = std::max(0.0, columns.first);
    double const right = std::min(camera.width - 1.0, columns.last);
    double const top = std::max(0.0, rows.first);
    double const bottom = std::min(camera.height - 1.0, rows.last);
    if (!(left <= right && top <= bottom)) return std::nullopt;
    splat.first_x = static_cast<std::uint32_t>(left);
    splat.last_x = static_cast<std::uint32_t>(right);
    splat.first_y = static_cast<std::uint32_t>(top);
    splat.last_y = static_cast<std::uint32_t>(bottom);
    return splat;
}

/// Blends splats, nearest first, into the rows [begin, end) of `rgb` (3 * width doubles a row).
TILEMESH_HOST void blend_reference_rows(std::span<ReferenceSplat const> nearest_first, std::uint32_t begin, std::uint32_t end, std::uint32_t width,
                                        CutOffs const& cuts, std::span<double> rgb, std::span<double> transmittance) noexcept;

} // namespace detail

/// The picture of `render_double` before it is rounded to float: 3 * width * height doubles, row by row from the top left.
template <class Records = std::span<splat::Gaussian const>>
std::vector<double> render_double_unrounded(Records const& gaussians, splat::Camera const& camera, splat::Rules const& rules, CutOffs const& cuts,
                                            unsigned threads = 1)
{
    std::vector<detail::ReferenceSplat> splats;
    for (auto const& gaussian : gaussians)
        if (auto const splat = detail::project_reference(gaussian, camera, rules, cuts)) splats.push_back(*splat);
    std::stable_sort(splats.begin(), splats.end(), [](auto const& a, auto const& b) { return a.depth != b.depth ? a.depth < b.depth : a.id < b.id; });

    auto const pixels = std::size_t{camera.width} * camera.height;
    std::vector<double> rgb(3 * pixels, 0.0);
    std::vector<double> transmittance(pixels, 1.0);
    {
        auto const bands = std::max(1u, std::min(threads, camera.height));
        auto const border = [&](unsigned band) { return static_cast<std::uint32_t>(std::uint64_t{camera.height} * band / bands); };
        auto const blend = [&](unsigned band) noexcept {
            detail::blend_reference_rows(splats, border(band), border(band + 1), camera.width, cuts, rgb, transmittance);
        };
        JoinedThreads workers;
        for (unsigned band = 1; band < bands; ++band) workers.start(blend, band);
        blend(0);
    }
    for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] += std::abs(transmittance[i / 3]) * rules.background[i % 3];
    return rgb;
}

/// The same picture with the cut-offs of the model (`Cuts::same`), or with no cut-off except `skip_below` (`Cuts::none`).
template <class Records = std::span<splat::Gaussian const>>
std::vector<double> render_double_unrounded(Records const& gaussians, splat::Camera const& camera, splat::Rules const& rules, Cuts cuts,
                                            unsigned threads = 1, double skip_below = 1e-12)
{
    return render_double_unrounded(gaussians, camera, rules, cuts == Cuts::same ? cut_offs(rules) : no_cut_offs(skip_below), threads);
}

/// Renders the picture that the model defines, in double from the float32 records. It is slow and simple, and it uses other formulas than
/// the kernels: EWA splatting (Zwicker et al. 2001) as 3D Gaussian Splatting writes it (Kerbl et al. 2023). Covariance R S S^T R^T, screen
/// covariance J W Sigma W^T J^T + dilation, conic by inversion, order by (depth, id) front to back. It has no tiles and no lists: every
/// splat visits every pixel of its box.
///
/// A Gaussian contributes nothing if its depth is not greater than `near_depth`, if its projection or colour is not finite, or if its
/// screen covariance is not positive definite. Ids must be unique.
///
/// Only `cuts` says what is left out. Of the model, the dilation, the Jacobian's limit, the near plane and the background count here. So a caller can
/// measure the cost of a cut-off that no model has. With `alpha_min` 0 no term is skipped; this costs splats x pixels unless `sigmas` or the square
/// bounds them. The result does not depend on `threads`, which divide the frame into horizontal bands.
///
/// Accuracy: about 1e-16 times the condition number of the screen covariance, before the rounding to float. That is 1e-9 for a needle of
/// 1,000 pixels, and worse than 1e-4 for a needle of 1e6 pixels. Cost: 32 bytes a pixel, and about 10 ns for each pixel of each box.
///
/// `gaussians` is a range of records of any degree. Harmonics are evaluated by their definition.
template <class Records = std::span<splat::Gaussian const>>
Image render_double(Records const& gaussians, splat::Camera const& camera, splat::Rules const& rules, CutOffs const& cuts, unsigned threads = 1)
{
    auto const rgb = render_double_unrounded(gaussians, camera, rules, cuts, threads);
    Image image{camera.width, camera.height};
    std::transform(rgb.begin(), rgb.end(), image.rgb.begin(), [](double value) { return static_cast<float>(value); });
    return image;
}

/// The picture with the model's cut-offs (`model.transmittance_min` is at most 1), or without any cut-off.
///
/// `skip_below`, with `Cuts::none` only: terms with a smaller alpha are left out. 0 leaves out no term and costs splats x pixels.
template <class Records = std::span<splat::Gaussian const>>
Image render_double(Records const& gaussians, splat::Camera const& camera, splat::Rules const& rules, Cuts cuts, unsigned threads = 1,
                    double skip_below = 1e-12)
{
    return render_double(gaussians, camera, rules, cuts == Cuts::same ? cut_offs(rules) : no_cut_offs(skip_below), threads);
}

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/reference_double_code.hpp>
#endif
