#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/map_sink.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <vector>

// Shared by the readers of compressed maps.
namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

using Bytes = std::vector<unsigned char>;
using ByteView = std::span<unsigned char const>;

/// The rest of a source.
inline Bytes read_rest(ByteSource& source)
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

/// Refuses a file that needs a decoder which the program does not have.
[[noreturn]] inline void refuse_without(std::string const& file, char const* is, char const* library, char const* package)
{
    throw Error(file + ' ' + is + " (this program was built without " + library + "); install " + package +
                " and build it again, or export the map as uncompressed PLY");
}

/// Refuses a compressed file that promises more rows than a real map of its length can have, before memory is set aside. The means of a real
/// map do not compress to a byte a Gaussian.
inline void require_plausible_rows(std::uint64_t rows, std::uint64_t file_bytes, std::string const& file)
{
    if (rows > file_bytes + 65536)
        throw Error(file + " promises " + std::to_string(rows) + " Gaussians (it has " + std::to_string(file_bytes) +
                    " bytes, and a map has at least one for each); copy or export the map again");
    require_ids(rows, file);
}

}}} // namespace tilemesh::v0_2::scene::detail
