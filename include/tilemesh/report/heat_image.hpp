#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/report/image.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// The values at the two ends of the colour map.
struct HeatRange {
    double least = 0, most = 0;
};

/// The least and the greatest of the finite values; 0 and 0 if there are none.
TILEMESH_HOST HeatRange finite_range(std::span<double const> values) noexcept;

/// The colour of values that are not finite: a grey that the colour map does not have.
inline constexpr std::array<float, 3> heat_gap = {160 / 255.0f, 160 / 255.0f, 160 / 255.0f};

/// The colour at `share` of the way from the least value (0, dark blue) to the greatest (1, yellow), as values of a picture.
/// Below 0 it is the first colour, above 1 the last, and for a NaN `heat_gap`.
///
/// Nine colours of viridis (Smith and van der Walt, matplotlib 2015, CC0), an eighth apart and joined by straight lines in
/// sRGB: the lightness rises all the way, for colour-blind eyes too and in print.
TILEMESH_HOST std::array<float, 3> heat_colour(double share) noexcept;

/// A map of `width` x `height` values, row by row from the top left, as a picture with `cell_px` x `cell_high_px` pixels per value.
/// `cell_high_px` 0: as high as wide. Values outside the range have the colour of its nearer end. If the range is empty (its ends are
/// equal), values above it have the last colour, and all others the first. Values that are not finite have the colour `heat_gap`.
///
/// Throws `Error` if the number of values is not width * height, for a range that is not finite or not in order, and for a
/// picture without pixels or with a side above 65,535.
TILEMESH_HOST Image heat_image(std::span<double const> values, std::uint32_t width, std::uint32_t height, HeatRange range,
                               std::uint32_t cell_px = 1, std::uint32_t cell_high_px = 0);

/// The colour map as a bar, the least value on the left. Throws `Error` for one without pixels.
TILEMESH_HOST Image heat_legend(std::uint32_t width, std::uint32_t height);

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/heat_image_code.hpp>
#endif
