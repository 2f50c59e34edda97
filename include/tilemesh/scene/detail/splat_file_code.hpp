#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/bytes.hpp>
#include <tilemesh/scene/detail/map_sink.hpp>
#include <tilemesh/scene/detail/ply_gaussian.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/splat_file.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene {

namespace detail {
/// Bytes of a row of a .splat file.
inline constexpr std::size_t splat_row_bytes = 32;
} // namespace detail

TILEMESH_HOST Map read_splat(std::istream& stream, std::string const& name)
{
    std::string const file = detail::shown(name, name.size());
    detail::ByteSource source(stream, file);
    std::uint64_t const rows = source.left() / detail::splat_row_bytes;
    if (source.left() % detail::splat_row_bytes != 0)
        throw Error(file + " ends inside row " + std::to_string(rows + 1) + " (a row of a .splat map has 32 bytes, and " +
                    std::to_string(source.left() % detail::splat_row_bytes) + " are there); copy or export the map again");
    if (rows == 0) throw Error(file + " is not a .splat map (it is empty); copy or export the map again");
    detail::require_ids(rows, file);

    Map map;
    map.name = std::filesystem::path(name).stem().string();
    map.path = name;
    map.notes.push_back("read as .splat: no view-dependent colour, colours and rotations of 8 bits");
    detail::MapSink sink(map, rows, 0);
    detail::GaussianRow row{};
    for (std::uint64_t number = 1; number <= rows; ++number) {
        auto const* const bytes = source.take(detail::splat_row_bytes);
        for (std::size_t i = 0; i < 3; ++i) {
            row[i] = static_cast<double>(detail::number_at<float>(bytes + 4 * i));
            row[7 + i] = detail::rounded_to_float(std::log(static_cast<double>(detail::number_at<float>(bytes + 12 + 4 * i))));
        }
        for (std::size_t i = 0; i < 4; ++i) row[10 + i] = (static_cast<double>(bytes[28 + i]) - 128.0) / 128.0;
        auto* const g = sink.add(number, row);
        if (!g) continue;
        for (std::size_t i = 0; i < 3; ++i) g->colour[i] = static_cast<float>(bytes[24 + i] / 255.0);
        g->opacity = static_cast<float>(bytes[27] / 255.0);
    }
    sink.finish();
    return map;
}

}}} // namespace tilemesh::scene
