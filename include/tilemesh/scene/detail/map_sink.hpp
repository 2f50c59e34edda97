#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/far_means.hpp>
#include <tilemesh/scene/detail/ply_gaussian.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/gaussian.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// A note names the first five items of a kind (rows, columns, elements): enough to find the cause, and short enough to print.
inline constexpr std::uint64_t named_in_notes = 5;

/// Ids are 32 bits wide and 0 is none.
inline void require_ids(std::uint64_t rows, std::string const& file)
{
    if (rows > std::numeric_limits<std::uint32_t>::max())
        throw Error(file + " has " + std::to_string(rows) + " rows (an id has 32 bits); split the map");
}

/// A number as a field of type float32 keeps it. A number that is too large for a float, or is not a number, stays as it is.
inline double rounded_to_float(double value)
{
    return std::fabs(value) <= static_cast<double>(std::numeric_limits<float>::max()) ? static_cast<double>(static_cast<float>(value)) : value;
}

/// Adds the rows of a file, of any format, to a map, in their order. A row that is not finite or has no rotation is left out and counted;
/// the notes name the first five.
class MapSink {
public:
    /// Sets memory aside for `rows` rows; the caller has checked that the file can hold them. The map has its degree already.
    /// `per_channel_in_file` coefficients of harmonics has the file, for the names of columns.
    MapSink(Map& map, std::uint64_t rows, std::uint32_t per_channel_in_file)
        : map_(map), coefficients_(3 * std::size_t{splat::harmonics_per_channel(map.sh_degree)}), in_file_(per_channel_in_file)
    {
        map.gaussians.reserve(static_cast<std::size_t>(rows));
        map.harmonics.reserve(static_cast<std::size_t>(rows) * coefficients_);
    }

    /// From here on, `cut_off` gets what float32 cuts off each mean, one for each record that is added.
    void keep_cut_off(CutOff& cut_off) { cut_off_ = &cut_off; }

    /// The number of coefficients of a row, of all channels.
    std::size_t coefficients() const { return coefficients_; }

    /// Adds row `number`, counted from 1: its id. Returns the record, or null if the row is rejected. With `harmonics` off, the coefficients
    /// of `row` are not looked at, and the caller adds them later.
    splat::Gaussian* add(std::uint64_t number, GaussianRow const& row, bool harmonics = true)
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

    /// Rejects row `number`. Returns null.
    splat::Gaussian* reject(std::uint64_t number, std::string const& why)
    {
        if (++map_.rejected <= named_in_notes) map_.notes.push_back("row " + std::to_string(number) + " rejected: " + why);
        return nullptr;
    }

    /// Notes how many rows were rejected and not named.
    void finish()
    {
        if (map_.rejected > named_in_notes) map_.notes.push_back("and " + std::to_string(map_.rejected - named_in_notes) + " more rows rejected");
    }

private:
    Map& map_;
    std::size_t coefficients_;
    std::uint32_t in_file_;
    CutOff* cut_off_ = nullptr;
};

}}} // namespace tilemesh::v0_2::scene::detail
