#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/ply_header.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// The properties that every Gaussian needs.
inline constexpr std::array<std::string_view, 14> needed_properties{"x",      "y",       "z",       "f_dc_0",  "f_dc_1",
                                                                    "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
                                                                    "rot_0",  "rot_1",   "rot_2",   "rot_3"};
/// The values of these properties, then up to 45 coefficients of harmonics: red, green and blue of each coefficient in turn.
using GaussianRow = std::array<double, needed_properties.size() + 45>;

/// The columns of these properties, then of the coefficients that are read. Empty for an element that is skipped.
using PlyColumns = std::vector<PlyProperty const*>;

/// Finds the needed properties by name. Throws `Error` if one is missing or is a list.
TILEMESH_HOST PlyColumns find_columns(PlyElement const& vertex, std::string const& file);

/// The harmonics of the highest degree that the file has and that the library reads.
struct PlyHarmonics {
    std::uint64_t columns = 0; ///< f_rest_*
    std::uint32_t file_degree = 0, degree = 0; ///< 0: none, or an unknown number of columns
};
/// Counts the columns f_rest_* and adds those of degree 1 to 3 to `columns`. The file has all of red, then all of green, then
/// all of blue.
TILEMESH_HOST PlyHarmonics find_harmonics(PlyElement const& vertex, PlyColumns& columns);

/// Turns the raw fields of a row into a record without its id. The colour is clamped at 0 unless harmonics are added to it later. Returns
/// null, or the fault of the row.
TILEMESH_HOST char const* make_gaussian(GaussianRow const& raw, splat::Gaussian& g, bool clamp_colour = true);

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/ply_gaussian_code.hpp>
#endif
