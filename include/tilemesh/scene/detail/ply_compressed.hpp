#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/map_sink.hpp>
#include <tilemesh/scene/detail/ply_gaussian.hpp>
#include <tilemesh/scene/detail/ply_header.hpp>
#include <tilemesh/scene/detail/ply_rows.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <vector>

TILEMESH_EXACT_BEGIN
namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// PlayCanvas' compressed PLY. Rows are in chunks of 256. Element `chunk` has the box of the means and of the scales of a chunk, and in files
/// of today that of its colours. A row of `vertex` is four words. A row of `sh` has a byte for each coefficient of harmonics.
///
/// Values: those of splat-transform's reader, in double and rounded to float32 as it rounds them. The opacity is byte / 255, which that
/// reader takes through a logarithm and back.
struct CompressedPly {
    static constexpr std::uint64_t chunk_rows = 256;
    static constexpr std::array<std::string_view, 18> box{"min_x",       "min_y",       "min_z",       "max_x",       "max_y",       "max_z",
                                                          "min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z",
                                                          "min_r",       "min_g",       "min_b",       "max_r",       "max_g",       "max_b"};
    static constexpr std::array<std::string_view, 4> packed{"packed_position", "packed_rotation", "packed_scale", "packed_color"};
    using Chunk = std::array<float, box.size()>;

    /// The unsigned number in the lowest `bits` of `word`, as a share of the largest such number.
    TILEMESH_HOST static double share(std::uint32_t word, std::uint32_t bits);
    TILEMESH_HOST static double between(float low, float high, double t);
    /// Three shares of 11, 10 and 11 bits within a box that begins at `at`.
    TILEMESH_HOST static void unpack_vector(std::uint32_t word, Chunk const& chunk, std::size_t at, double* out);
    /// The three smallest of w, x, y, z in 10 bits each, from -1/sqrt(2) to 1/sqrt(2); two bits name the largest.
    TILEMESH_HOST static void unpack_rotation(std::uint32_t word, double* out);
    /// The fields of a row, all but the opacity.
    TILEMESH_HOST static void unpack(std::array<std::uint32_t, 4> const& words, Chunk const& chunk, bool coloured,
                                     GaussianRow& row);
    /// A coefficient of harmonics, from -4 to 4.
    TILEMESH_HOST static float coefficient(std::uint32_t byte);
};

/// Finds the first `count` of these properties. Throws `Error` if one is missing or has another type than `type`.
template <std::size_t N>
PlyColumns find_packed(PlyElement const& element, std::array<std::string_view, N> const& names, std::size_t count, PlyType type,
                       std::string const& file)
{
    PlyColumns columns;
    for (std::size_t i = 0; i < count; ++i) {
        auto const* const property = element.find(names[i]);
        if (!property || property->is_list() || property->type != type)
            throw Error(file + " has no property " + std::string(names[i]) + (type == PlyType::float32 ? " of type float" : " of type uint") +
                        " in element " + in_quotes(element.name) + " (a compressed PLY needs it); export the map again");
        columns.push_back(property);
    }
    return columns;
}

TILEMESH_HOST Map read_compressed_ply(ByteSource& source, PlyHeader const& header, PlyElement const& vertex,
                                      std::string const& name);

}}} // namespace tilemesh::scene::detail
TILEMESH_EXACT_END

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/ply_compressed_code.hpp>
#endif
