#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/map_sink.hpp>
#include <tilemesh/scene/detail/packed_input.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

TILEMESH_HOST Bytes read_rest(ByteSource& source)
{
    Bytes out;
    out.reserve(static_cast<std::size_t>(source.left()));
    while (source.left() != 0) {
        auto const n = static_cast<std::size_t>(std::min<std::uint64_t>(source.left(), ByteSource::capacity));
        auto const* const bytes = source.take(n);
        out.insert(out.end(), bytes, bytes + n);
    }
    return out;
}

TILEMESH_HOST void require_plausible_rows(std::uint64_t rows, std::uint64_t file_bytes, std::string const& file)
{
    if (rows > file_bytes + 65536)
        throw Error(file + " promises " + std::to_string(rows) + " Gaussians (it has " + std::to_string(file_bytes) +
                    " bytes, and a map has at least one for each); copy or export the map again");
    require_ids(rows, file);
}

}}} // namespace tilemesh::scene
