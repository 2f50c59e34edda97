#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/ply_header.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <vector>

namespace tilemesh::scene {

namespace detail {

static_assert(std::endian::native == std::endian::little,
              "words of a PLY body are copied, not swapped");

template <class T>
double word_as_double(std::byte const* bytes)
{
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return static_cast<double>(value);
}

inline double read_scalar(std::byte const* bytes, PlyType type)
{
    switch (type) {
    case PlyType::int8: return word_as_double<std::int8_t>(bytes);
    case PlyType::uint8: return word_as_double<std::uint8_t>(bytes);
    case PlyType::int16: return word_as_double<std::int16_t>(bytes);
    case PlyType::uint16: return word_as_double<std::uint16_t>(bytes);
    case PlyType::int32: return word_as_double<std::int32_t>(bytes);
    case PlyType::uint32: return word_as_double<std::uint32_t>(bytes);
    case PlyType::float32: return word_as_double<float>(bytes);
    case PlyType::float64: break;
    }
    return word_as_double<double>(bytes);
}

/// What a row needs, in the order of `make_gaussian`.
inline constexpr std::array<std::string_view, 14> needed_properties{
    "x",       "y",       "z",       "f_dc_0", "f_dc_1", "f_dc_2", "opacity",
    "scale_0", "scale_1", "scale_2", "rot_0",  "rot_1",  "rot_2",  "rot_3"};

/// Turns the raw fields of a row into a record without its id. Null, or what is wrong with the row.
inline char const* make_gaussian(std::array<double, 14> const& raw, splat::Gaussian& g)
{
    constexpr double infinity = std::numeric_limits<double>::infinity();
    constexpr double largest = std::numeric_limits<float>::max();
    static constexpr std::array<char const*, 14> not_finite{
        "x is not finite",       "y is not finite",       "z is not finite",
        "f_dc_0 is not finite",  "f_dc_1 is not finite",  "f_dc_2 is not finite",
        "opacity is not finite", "scale_0 is not finite", "scale_1 is not finite",
        "scale_2 is not finite", "rot_0 is not finite",   "rot_1 is not finite",
        "rot_2 is not finite",   "rot_3 is not finite"};

    // An infinite logit is an opacity of 0 or 1, and a log scale of -infinity a size of zero: both
    // are meant. NaN fails every comparison. A number too large for a float counts as infinite.
    for (std::size_t i = 0; i < raw.size(); ++i) {
        bool const meant =
            (i == 6 && std::fabs(raw[i]) <= infinity) || (i >= 7 && i < 10 && raw[i] < 0.0);
        if (!meant && !(std::fabs(raw[i]) <= largest)) return not_finite[i];
    }

    for (std::size_t i = 0; i < 3; ++i) {
        g.mean_world[i] = static_cast<float>(raw[i]);
        // 0.28209479 = 1 / (2 sqrt(pi)), the spherical harmonic of degree 0. Fused on every build:
        // equal bits.
        g.colour[i] = static_cast<float>(
            std::min(std::fmax(std::fma(0.28209479, raw[3 + i], 0.5), 0.0), largest));
        // e^-87 = 1.6e-38 is the last whole step above the smallest normal float: below it a size
        // is zero in float, and a finite number keeps the projection free of infinities.
        g.log_scale[i] = static_cast<float>(std::fmax(raw[7 + i], -87.0));
    }
    g.opacity = static_cast<float>(1.0 / (1.0 + std::exp(-raw[6])));

    // The largest component becomes 1 before anything is squared: tiny and huge quaternions
    // survive.
    double longest = 0.0;
    for (std::size_t i = 10; i < 14; ++i) longest = std::fmax(longest, std::fabs(raw[i]));
    if (longest == 0.0) return "rot_0..3 is zero";
    double squares = 0.0;
    for (std::size_t i = 10; i < 14; ++i) squares += (raw[i] / longest) * (raw[i] / longest);
    for (std::size_t i = 0; i < 4; ++i)
        g.rotation[i] = static_cast<float>(raw[10 + i] / longest / std::sqrt(squares));
    return nullptr;
}

/// Checks that the body holds what the header promises, in 64 bits and by division only: a count
/// may be anything. Returns the bytes that follow the last row.
inline std::uint64_t require_rows(PlyHeader const& header, std::uint64_t file_bytes,
                                  std::string const& file)
{
    std::uint64_t left = file_bytes - std::min(file_bytes, header.bytes);
    for (auto const& element : header.elements) {
        if (element.row_bytes == 0) continue;
        std::uint64_t const there = left / element.row_bytes;
        if (there < element.count)
            throw Error(file + " ends inside row " + std::to_string(there + 1) + " of element " +
                        in_quotes(element.name) + " (the header promises " +
                        std::to_string(element.count) + " rows of " +
                        std::to_string(element.row_bytes) + " bytes, " + std::to_string(there) +
                        " are there); copy or export the map again");
        left -= element.count * element.row_bytes;
    }
    return left;
}

} // namespace detail

/// Reads a 3DGS map: binary little-endian PLY, the needed properties of element `vertex` found by
/// name, in any order and of any scalar type. Stored are: the mean; colour `0.28209479 f_dc + 0.5`,
/// clamped at 0 from below; the sigmoid of `opacity`; `scale_*` as it is, but not below -87;
/// `rot_0..3` = w, x, y, z, normalised. `f_rest_*`, other properties and other elements are
/// skipped, with a note.
///
/// Rows that are not finite or have a zero quaternion are left out and counted; the notes name the
/// first five, numbered from 1 as the ids are. An infinite `opacity` and a `scale` of -infinity are
/// values. Throws `Error` for what is no such file and for a body shorter than its header promises,
/// before any row is stored.
///
/// Cost: 60 bytes a Gaussian and 1 MiB; the file is read once.
inline Map load_ply(std::filesystem::path const& path)
{
    namespace fs = std::filesystem;
    std::string const file = path.string();
    std::error_code failed;
    fs::file_status const status = fs::status(path, failed);
    if (!fs::exists(status)) throw Error(file + " cannot be opened (no such file); check the path");
    if (fs::is_directory(status))
        throw Error(file + " cannot be read (it is a directory); name a PLY file in it");
    std::uint64_t const file_bytes = fs::file_size(path, failed);
    if (failed)
        throw Error(file + " cannot be read (" + failed.message() + "); name a regular file");
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw Error(file + " cannot be opened (no permission); check its access rights");

    detail::PlyHeader const header = detail::read_ply_header(stream, file);
    std::uint64_t const bytes_after = detail::require_rows(header, file_bytes, file);

    // Find the needed columns, and say what is not used.
    Map map{path.stem().string(), file, {}, 0, {}};
    detail::PlyElement const* vertex = nullptr;
    std::uint64_t bytes_before = 0;
    for (auto const& element : header.elements) {
        if (element.name == "vertex") vertex = &element;
        else
            map.notes.push_back("element " + detail::in_quotes(element.name) + ": " +
                                std::to_string(element.count) + " rows skipped");
        if (!vertex) bytes_before += element.count * element.row_bytes;
    }
    if (!vertex)
        throw Error(
            file +
            " has no element vertex (a 3DGS map keeps its Gaussians there); name a 3DGS map");
    std::array<detail::PlyProperty const*, 14> columns{};
    std::string missing;
    for (std::size_t i = 0; i < columns.size(); ++i) {
        columns[i] = vertex->find(detail::needed_properties[i]);
        if (!columns[i])
            missing += (missing.empty() ? "" : ", ") + std::string(detail::needed_properties[i]);
    }
    if (!missing.empty())
        throw Error(
            file + " has no property " + missing +
            " (a 3DGS map needs x y z, f_dc_0..2, opacity, scale_0..2, rot_0..3); name a 3DGS map");
    std::uint64_t rest = 0;
    std::string unused;
    for (auto const& property : vertex->properties) {
        auto const used = [&](auto const* column) { return column == &property; };
        if (std::any_of(columns.begin(), columns.end(), used)) continue;
        if (property.name.rfind("f_rest_", 0) == 0) ++rest;
        else unused += (unused.empty() ? "" : ", ") + property.name;
    }
    if (rest)
        map.notes.push_back("f_rest_*: " + std::to_string(rest) +
                            " columns of view-dependent colour skipped");
    if (!unused.empty()) map.notes.push_back("columns skipped: " + unused);
    if (bytes_after)
        map.notes.push_back(std::to_string(bytes_after) + " bytes after the last row skipped");

    // Ids are 32 bits wide and 0 is none.
    if (vertex->count > std::numeric_limits<std::uint32_t>::max())
        throw Error(file + " has " + std::to_string(vertex->count) +
                    " rows (an id has 32 bits); split the map");

    // Read about 1 MiB of whole rows at a time.
    stream.seekg(static_cast<std::streamoff>(header.bytes + bytes_before));
    map.gaussians.reserve(static_cast<std::size_t>(vertex->count));
    std::uint64_t const rows_at_once =
        std::max<std::uint64_t>(1, (std::uint64_t{1} << 20) / vertex->row_bytes);
    std::vector<std::byte> rows(
        static_cast<std::size_t>(std::min(rows_at_once, vertex->count) * vertex->row_bytes));
    for (std::uint64_t first = 0; first < vertex->count; first += rows_at_once) {
        std::uint64_t const count = std::min(rows_at_once, vertex->count - first);
        stream.read(reinterpret_cast<char*>(rows.data()),
                    static_cast<std::streamsize>(count * vertex->row_bytes));
        if (!stream)
            throw Error(file + " cannot be read to its end (rows " + std::to_string(first + 1) +
                        " and on: it changed, or the disk failed); copy the file and try again");
        for (std::uint64_t i = 0; i < count; ++i) {
            std::byte const* row = rows.data() + i * vertex->row_bytes;
            std::array<double, 14> raw;
            for (std::size_t k = 0; k < raw.size(); ++k)
                raw[k] = detail::read_scalar(row + columns[k]->offset, columns[k]->type);

            splat::Gaussian g;
            std::uint64_t const number = first + i + 1;
            if (char const* why = detail::make_gaussian(raw, g)) {
                constexpr std::uint64_t named_rows =
                    5; // enough to find the cause, short enough to print
                if (++map.rejected <= named_rows)
                    map.notes.push_back("row " + std::to_string(number) + " rejected: " + why);
                continue;
            }
            g.id = splat::GaussianId{static_cast<std::uint32_t>(number)};
            map.gaussians.push_back(g);
        }
    }
    if (map.rejected > 5)
        map.notes.push_back("and " + std::to_string(map.rejected - 5) + " more rows rejected");
    return map;
}

} // namespace tilemesh::scene
