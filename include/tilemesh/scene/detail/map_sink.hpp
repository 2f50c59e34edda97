#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/far_means.hpp>
#include <tilemesh/scene/detail/ply_gaussian.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/gaussian.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// A note names the first five items of a kind (rows, columns, elements): enough to find the cause, and short enough to print.
inline constexpr std::uint64_t named_in_notes = 5;

/// Ids are 32 bits wide and 0 is none.
TILEMESH_HOST void require_ids(std::uint64_t rows, std::string const& file);

/// A number as a field of type float32 keeps it. A number that is too large for a float, or is not a number, stays as it is.
TILEMESH_HOST double rounded_to_float(double value);

/// Adds the rows of a file, of any format, to a map, in their order. A row that is not finite or has no rotation is left out and counted;
/// the notes name the first five.
class MapSink {
public:
    /// Sets memory aside for `rows` rows; the caller has checked that the file can hold them. The map has its degree already.
    /// `per_channel_in_file` coefficients of harmonics has the file, for the names of columns.
    TILEMESH_HOST MapSink(Map& map, std::uint64_t rows, std::uint32_t per_channel_in_file);

    /// From here on, `cut_off` gets what float32 cuts off each mean, one for each record that is added.
    void keep_cut_off(CutOff& cut_off) { cut_off_ = &cut_off; }

    /// The number of coefficients of a row, of all channels.
    std::size_t coefficients() const { return coefficients_; }

    /// Adds row `number`, counted from 1: its id. Returns the record, or null if the row is rejected. With `harmonics` off, the coefficients
    /// of `row` are not looked at, and the caller adds them later.
    TILEMESH_HOST splat::Gaussian* add(std::uint64_t number, GaussianRow const& row, bool harmonics = true);

    /// Rejects row `number`. Returns null.
    TILEMESH_HOST splat::Gaussian* reject(std::uint64_t number, std::string const& why);

    /// Notes how many rows were rejected and not named.
    TILEMESH_HOST void finish();

private:
    Map& map_;
    std::size_t coefficients_;
    std::uint32_t in_file_;
    CutOff* cut_off_ = nullptr;
};

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/map_sink_code.hpp>
#endif
