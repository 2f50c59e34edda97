#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/ply_header.hpp>
#include <tilemesh/splat/gaussian.hpp>

namespace tilemesh::scene::detail {

/// What a Gaussian needs of a row.
inline constexpr std::array<std::string_view, 14> needed_properties{"x",      "y",       "z",       "f_dc_0",  "f_dc_1",
                                                                    "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
                                                                    "rot_0",  "rot_1",   "rot_2",   "rot_3"};
using GaussianRow = std::array<double, needed_properties.size()>;

/// Where they are; all null: an element that is passed over.
using PlyColumns = std::array<PlyProperty const*, needed_properties.size()>;

/// Finds them by name. Throws `Error` for those that are absent or lists.
inline PlyColumns find_columns(PlyElement const& vertex, std::string const& file)
{
    PlyColumns columns{};
    std::string missing;
    for (std::size_t i = 0; i < columns.size(); ++i) {
        columns[i] = vertex.find(needed_properties[i]);
        if (columns[i] && columns[i]->is_list())
            throw Error(file + " has a list as property " + columns[i]->name +
                        " (a 3DGS map has one number there); name a 3DGS map");
        if (!columns[i]) missing.append(missing.empty() ? "" : ", ").append(needed_properties[i]);
    }
    if (!missing.empty())
        throw Error(file + " has no property " + missing +
                    " (a 3DGS map needs x y z, f_dc_0..2, opacity, scale_0..2, rot_0..3); name a 3DGS map");
    return columns;
}

/// Turns the raw fields of a row into a record without its id. Null, or what is wrong with the row.
inline char const* make_gaussian(GaussianRow const& raw, splat::Gaussian& g)
{
    constexpr double infinity = std::numeric_limits<double>::infinity();
    constexpr double largest = static_cast<double>(std::numeric_limits<float>::max());
    static constexpr std::array<char const*, 14> not_finite{
        "x is not finite",       "y is not finite",       "z is not finite",       "f_dc_0 is not finite",
        "f_dc_1 is not finite",  "f_dc_2 is not finite",  "opacity is not finite", "scale_0 is not finite",
        "scale_1 is not finite", "scale_2 is not finite", "rot_0 is not finite",   "rot_1 is not finite",
        "rot_2 is not finite",   "rot_3 is not finite"};

    // An infinite logit is an opacity of 0 or 1, and a log scale of -infinity a size of zero: both are meant. NaN fails every
    // comparison. A number too large for a float counts as infinite.
    for (std::size_t i = 0; i < raw.size(); ++i) {
        bool const meant = (i == 6 && std::fabs(raw[i]) <= infinity) || (i >= 7 && i < 10 && raw[i] < 0.0);
        if (!meant && !(std::fabs(raw[i]) <= largest)) return not_finite[i];
    }

    for (std::size_t i = 0; i < 3; ++i) {
        g.mean_world[i] = static_cast<float>(raw[i]);
        // 0.28209479 = 1 / (2 sqrt(pi)), the spherical harmonic of degree 0. Fused on every build: equal bits.
        g.colour[i] = static_cast<float>(std::min(std::fmax(std::fma(0.28209479, raw[3 + i], 0.5), 0.0), largest));
        // e^-87 = 1.6e-38 is the last whole step above the smallest normal float: below it a size is zero in float, and a
        // finite number keeps the projection free of infinities.
        g.log_scale[i] = static_cast<float>(std::fmax(raw[7 + i], -87.0));
    }
    g.opacity = static_cast<float>(1.0 / (1.0 + std::exp(-raw[6])));

    // The largest component becomes 1 before anything is squared: tiny and huge quaternions survive.
    double longest = 0.0;
    for (std::size_t i = 10; i < 14; ++i) longest = std::fmax(longest, std::fabs(raw[i]));
    if (longest == 0.0) return "rot_0..3 is zero";
    double squares = 0.0;
    for (std::size_t i = 10; i < 14; ++i) squares += (raw[i] / longest) * (raw[i] / longest);
    for (std::size_t i = 0; i < 4; ++i) g.rotation[i] = static_cast<float>(raw[10 + i] / longest / std::sqrt(squares));
    return nullptr;
}

} // namespace tilemesh::scene::detail
