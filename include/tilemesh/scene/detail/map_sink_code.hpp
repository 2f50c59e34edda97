#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/map_sink.hpp>
#include <tilemesh/scene/detail/ply_gaussian.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/gaussian.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

TILEMESH_HOST void require_ids(std::uint64_t rows, std::string const& file)
{
    if (rows > std::numeric_limits<std::uint32_t>::max())
        throw Error(file + " has " + std::to_string(rows) + " rows (an id has 32 bits); split the map");
}

TILEMESH_HOST double rounded_to_float(double value)
{
    return std::fabs(value) <= static_cast<double>(std::numeric_limits<float>::max()) ? static_cast<double>(static_cast<float>(value))
                                                                                      : value;
}

TILEMESH_HOST MapSink::MapSink(Map& map, std::uint64_t rows, std::uint32_t per_channel_in_file)
    : map_(map), coefficients_(3 * std::size_t{splat::harmonics_per_channel(map.sh_degree)}), in_file_(per_channel_in_file)
{
    map.gaussians.reserve(static_cast<std::size_t>(rows));
    map.harmonics.reserve(static_cast<std::size_t>(rows) * coefficients_);
}

TILEMESH_HOST splat::Gaussian* MapSink::add(std::uint64_t number, GaussianRow const& row, bool harmonics)
{
    splat::Gaussian g{};
    if (char const* const wrong = make_gaussian(row, g, map_.sh_degree == 0)) return reject(number, wrong);
    std::size_t const first = needed_properties.size(), count = harmonics ? coefficients_ : 0;
    for (std::size_t i = 0; i < count; ++i)
        if (!(std::fabs(row[first + i]) <= static_cast<double>(std::numeric_limits<float>::max())))
            return reject(number, "f_rest_" + std::to_string(i % 3 * in_file_ + i / 3) + " is not finite");
    g.id = splat::GaussianId{static_cast<std::uint32_t>(number)};
    map_.gaussians.push_back(g);
    if (cut_off_ != nullptr) {
        auto& rest = cut_off_->emplace_back();
        for (std::size_t i = 0; i < 3; ++i) rest[i] = static_cast<float>(row[i] - static_cast<double>(g.mean_world[i]));
    }
    for (std::size_t i = 0; i < count; ++i) map_.harmonics.push_back(static_cast<float>(row[first + i]));
    return &map_.gaussians.back();
}

TILEMESH_HOST splat::Gaussian* MapSink::reject(std::uint64_t number, std::string const& why)
{
    if (++map_.rejected <= named_in_notes) map_.notes.push_back("row " + std::to_string(number) + " rejected: " + why);
    return nullptr;
}

TILEMESH_HOST void MapSink::finish()
{
    if (map_.rejected > named_in_notes)
        map_.notes.push_back("and " + std::to_string(map_.rejected - named_in_notes) + " more rows rejected");
}

}}} // namespace tilemesh::scene::detail
