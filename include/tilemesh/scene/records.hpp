#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// The check of a map at every function that takes one and reads its harmonics. Throws `Error` if the degree is above 3, or if the number of
/// coefficients does not fit the degree.
TILEMESH_HOST void require_harmonics(Map const& map);

/// The map's records, of the type that a setup stores. Harmonics that the map does not have are zero; this changes no bit of the picture.
/// Throws `Error` as `require_harmonics`, and if the map has a higher degree than the record; call `at_degree` to drop the higher degrees on purpose.
template <class Record>
std::vector<Record> records(Map const& map)
{
    require_harmonics(map);
    if (map.sh_degree > Record::sh_degree)
        throw Error("a map with view-dependent colour of degree " + std::to_string(map.sh_degree) + " (the setup's records hold degree " +
                    std::to_string(Record::sh_degree) + "); give the records that degree (splat::fitted(setup, " + std::to_string(map.sh_degree) +
                    ")), or give up the rest with scene::at_degree");
    if constexpr (Record::sh_degree == 0) {
        return map.gaussians;
    } else {
        std::size_t const floats = 3 * splat::harmonics_per_channel(map.sh_degree);
        std::vector<Record> out(map.gaussians.size());
        for (std::size_t i = 0; i < out.size(); ++i) {
            static_cast<splat::Gaussian&>(out[i]) = map.gaussians[i];
            std::copy_n(map.harmonics.begin() + static_cast<std::ptrdiff_t>(i * floats), floats, out[i].harmonics);
        }
        return out;
    }
}

/// Calls f with the map's records, a vector of its own degree, and returns what f returns. Throws `Error` as `require_harmonics`.
template <class F>
auto visit_records(Map const& map, F const& f)
{
    require_harmonics(map);
    switch (map.sh_degree) {
    case 0:
        return f(map.gaussians);
    case 1:
        return f(records<splat::ShadedGaussian<1>>(map));
    case 2:
        return f(records<splat::ShadedGaussian<2>>(map));
    default:
        return f(records<splat::ShadedGaussian<3>>(map));
    }
}

/// Returns the map with harmonics up to `degree` only. At degree 0 its colours are clamped at 0, as in a map without harmonics. A viewer
/// without view-dependent colour shows this map. Throws `Error` as `require_harmonics`.
TILEMESH_HOST Map at_degree(Map map, std::uint32_t degree);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/records_code.hpp>
#endif
