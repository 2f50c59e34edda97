#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/map_sink.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <vector>

// Shared by the readers of compressed maps.
namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

using Bytes = std::vector<unsigned char>;
using ByteView = std::span<unsigned char const>;

/// The rest of a source.
TILEMESH_HOST Bytes read_rest(ByteSource& source);

/// Refuses a file that needs a decoder which the program does not have.
[[noreturn]] inline void refuse_without(std::string const& file, char const* is, char const* library, char const* package)
{
    throw Error(file + ' ' + is + " (this program was built without " + library + "); install " + package +
                " and build it again, or export the map as uncompressed PLY");
}

/// Refuses a compressed file that promises more rows than a real map of its length can have, before memory is set aside. The means of a real
/// map do not compress to a byte a Gaussian.
TILEMESH_HOST void require_plausible_rows(std::uint64_t rows, std::uint64_t file_bytes, std::string const& file);

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/packed_input_code.hpp>
#endif
