#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/ply_header.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// The properties that every Gaussian needs.
inline constexpr std::array<std::string_view, 14> needed_properties{"x",       "y",       "z",       "f_dc_0", "f_dc_1", "f_dc_2", "opacity",
                                                                    "scale_0", "scale_1", "scale_2", "rot_0",  "rot_1",  "rot_2",  "rot_3"};
/// The values of these properties, then up to 45 coefficients of harmonics: red, green and blue of each coefficient in turn.
using GaussianRow = std::array<double, needed_properties.size() + 45>;

/// The columns of these properties, then of the coefficients that are read. Empty for an element that is skipped.
using PlyColumns = std::vector<PlyProperty const*>;

/// Finds the needed properties by name. Throws `Error` if one is missing or is a list.
inline PlyColumns find_columns(PlyElement const& vertex, std::string const& file)
{
    PlyColumns columns(needed_properties.size());
    std::string missing;
    for (std::size_t i = 0; i < columns.size(); ++i) {
        columns[i] = vertex.find(needed_properties[i]);
        if (columns[i] && columns[i]->is_list())
            throw Error(file + " has a list as property " + columns[i]->name + " (a 3DGS map has one number there); name a 3DGS map");
        if (!columns[i]) missing.append(missing.empty() ? "" : ", ").append(needed_properties[i]);
    }
    if (!missing.empty())
        throw Error(file + " has no property " + missing + " (a 3DGS map needs x y z, f_dc_0..2, opacity, scale_0..2, rot_0..3); name a 3DGS map");
    return columns;
}

/// The harmonics of the highest degree that the file has and that the library reads.
struct PlyHarmonics {
    std::uint64_t columns = 0;                 ///< f_rest_*
    std::uint32_t file_degree = 0, degree = 0; ///< 0: none, or an unknown number of columns
};
/// Counts the columns f_rest_* and adds those of degree 1 to 3 to `columns`. The file has all of red, then all of green, then
/// all of blue.
inline PlyHarmonics find_harmonics(PlyElement const& vertex, PlyColumns& columns)
{
    PlyHarmonics found;
    for (auto const& property : vertex.properties) found.columns += property.name.starts_with("f_rest_") ? 1 : 0;
    std::uint32_t degree = 0;
    while (3 * std::uint64_t{splat::harmonics_per_channel(degree)} < found.columns && degree < 100) ++degree;
    std::uint32_t const in_file = splat::harmonics_per_channel(degree);
    if (degree == 0 || 3 * std::uint64_t{in_file} != found.columns) return found;
    found.file_degree = degree;
    PlyColumns all = columns;
    for (std::uint32_t k = 0; k < splat::harmonics_per_channel(std::min(degree, 3u)); ++k)
        for (std::uint32_t channel = 0; channel < 3; ++channel) {
            auto const* const property = vertex.find("f_rest_" + std::to_string(channel * in_file + k));
            if (!property || property->is_list()) return found; // an unknown numbering
            all.push_back(property);
        }
    columns = all;
    found.degree = std::min(degree, 3u);
    return found;
}

/// Turns the raw fields of a row into a record without its id. The colour is clamped at 0 unless harmonics are added to it later. Returns
/// null, or the fault of the row.
inline char const* make_gaussian(GaussianRow const& raw, splat::Gaussian& g, bool clamp_colour = true)
{
    constexpr double infinity = std::numeric_limits<double>::infinity();
    constexpr double largest = static_cast<double>(std::numeric_limits<float>::max());
    static constexpr std::array<char const*, 14> not_finite{"x is not finite",       "y is not finite",       "z is not finite",
                                                            "f_dc_0 is not finite",  "f_dc_1 is not finite",  "f_dc_2 is not finite",
                                                            "opacity is not finite", "scale_0 is not finite", "scale_1 is not finite",
                                                            "scale_2 is not finite", "rot_0 is not finite",   "rot_1 is not finite",
                                                            "rot_2 is not finite",   "rot_3 is not finite"};

    // An infinite logit is an opacity of 0 or 1, and a log scale of -infinity is a size of zero; both are valid. NaN fails every
    // comparison. A number too large for a float counts as infinite.
    for (std::size_t i = 0; i < needed_properties.size(); ++i) {
        bool const meant = (i == 6 && std::fabs(raw[i]) <= infinity) || (i >= 7 && i < 10 && raw[i] < 0.0);
        if (!meant && !(std::fabs(raw[i]) <= largest)) return not_finite[i];
    }

    for (std::size_t i = 0; i < 3; ++i) {
        g.mean_world[i] = static_cast<float>(raw[i]);
        // 0.28209479 = 1 / (2 sqrt(pi)), the spherical harmonic of degree 0. The operation is fused on every build, so all builds give
        // equal bits.
        double const colour = std::fma(0.28209479, raw[3 + i], 0.5);
        g.colour[i] = static_cast<float>(std::clamp(colour, clamp_colour ? 0.0 : -largest, largest));
        // e^-87 = 1.6e-38 is the last whole step above the smallest normal float. A size below it is zero in float, and a finite number
        // keeps infinities out of the projection.
        g.log_scale[i] = static_cast<float>(std::fmax(raw[7 + i], -87.0));
    }
    g.opacity = static_cast<float>(1.0 / (1.0 + std::exp(-raw[6])));

    // The largest component becomes 1 before squaring, so tiny and huge quaternions keep their direction.
    double longest = 0.0;
    for (std::size_t i = 10; i < 14; ++i) longest = std::fmax(longest, std::fabs(raw[i]));
    if (longest == 0.0) return "rot_0..3 is zero";
    double squares = 0.0;
    for (std::size_t i = 10; i < 14; ++i) squares += (raw[i] / longest) * (raw[i] / longest);
    for (std::size_t i = 0; i < 4; ++i) g.rotation[i] = static_cast<float>(raw[10 + i] / longest / std::sqrt(squares));
    return nullptr;
}

}}} // namespace tilemesh::v0_2::scene::detail
