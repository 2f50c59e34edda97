#pragma once
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
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
    static double share(std::uint32_t word, std::uint32_t bits)
    {
        std::uint32_t const most = (1u << bits) - 1u;
        return static_cast<double>(word & most) / static_cast<double>(most);
    }
    static double between(float low, float high, double t) { return static_cast<double>(low) * (1.0 - t) + static_cast<double>(high) * t; }
    /// Three shares of 11, 10 and 11 bits within a box that begins at `at`.
    static void unpack_vector(std::uint32_t word, Chunk const& chunk, std::size_t at, double* out)
    {
        std::array<double, 3> const t{share(word >> 21, 11), share(word >> 11, 10), share(word, 11)};
        for (std::size_t i = 0; i < 3; ++i) out[i] = rounded_to_float(between(chunk[at + i], chunk[at + 3 + i], t[i]));
    }
    /// The three smallest of w, x, y, z in 10 bits each, from -1/sqrt(2) to 1/sqrt(2); two bits name the largest.
    static void unpack_rotation(std::uint32_t word, double* out)
    {
        double const norm = 1.0 / (std::sqrt(2.0) * 0.5);
        std::array<double, 3> const small{(share(word >> 20, 10) - 0.5) * norm, (share(word >> 10, 10) - 0.5) * norm, (share(word, 10) - 0.5) * norm};
        std::uint32_t const largest = word >> 30;
        for (std::uint32_t i = 0, k = 0; i < 4; ++i)
            if (i != largest) out[i] = rounded_to_float(small[k++]);
        double const squares = small[0] * small[0] + small[1] * small[1] + small[2] * small[2];
        out[largest] = rounded_to_float(std::sqrt(std::fmax(0.0, 1.0 - squares)));
    }
    /// The fields of a row, all but the opacity.
    static void unpack(std::array<std::uint32_t, 4> const& words, Chunk const& chunk, bool coloured, GaussianRow& row)
    {
        unpack_vector(words[0], chunk, 0, row.data());
        unpack_vector(words[2], chunk, 6, row.data() + 7);
        unpack_rotation(words[1], row.data() + 10);
        for (std::size_t i = 0; i < 3; ++i) {
            double colour = share(words[3] >> (24 - 8 * i), 8);
            if (coloured) colour = between(chunk[12 + i], chunk[15 + i], colour);
            row[3 + i] = rounded_to_float((colour - 0.5) / 0.28209479177387814); // 1 / (2 sqrt(pi)) as the reference reader writes it
        }
        row[6] = 0.0;
    }
    /// A coefficient of harmonics, from -4 to 4.
    static float coefficient(std::uint32_t byte)
    {
        double const t = byte == 0 ? 0.0 : byte == 255 ? 1.0 : (byte + 0.5) / 256.0;
        return static_cast<float>((t - 0.5) * 8.0);
    }
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

inline Map read_compressed_ply(ByteSource& source, PlyHeader const& header, PlyElement const& vertex, std::string const& name)
{
    std::string const file = shown(name, name.size());
    auto const refuse = [&](std::string const& why) {
        throw Error(file + " cannot be read as a compressed PLY (" + why + "); export the map again");
    };
    if (header.format == PlyFormat::ascii) refuse("it is ASCII; its rows are words of bits");
    PlyElement const *chunk = nullptr, *sh = nullptr;
    for (auto const& element : header.elements) {
        if (element.name == "chunk" && &element < &vertex) chunk = &element;
        if (element.name == "sh" && &element > &vertex) sh = &element;
    }
    if (!chunk) refuse("there is no element chunk before its element vertex");
    bool const coloured = chunk->find("min_r") != nullptr;
    PlyColumns const box = find_packed(*chunk, CompressedPly::box, coloured ? 18 : 12, PlyType::float32, file);
    PlyColumns const packed = find_packed(vertex, CompressedPly::packed, 4, PlyType::uint32, file);
    PlyColumns coefficients;
    PlyHarmonics harmonics;
    if (sh) harmonics = find_harmonics(*sh, coefficients);
    for (auto const* column : coefficients)
        if (column->type != PlyType::uint8) refuse("property " + column->name + " of element \"sh\" is not of type uchar");
    require_rows(header, source.left(), file);
    require_ids(vertex.count, file);
    std::uint64_t const chunks = vertex.count / CompressedPly::chunk_rows + (vertex.count % CompressedPly::chunk_rows != 0 ? 1 : 0);
    if (chunk->count != chunks)
        refuse(std::to_string(vertex.count) + " rows are in " + std::to_string(chunks) + " chunks of 256, and there are " +
               std::to_string(chunk->count));
    if (harmonics.degree != 0 && sh->count != vertex.count)
        refuse("element \"sh\" has " + std::to_string(sh->count) + " rows for " + std::to_string(vertex.count) + " Gaussians");

    Map map;
    map.name = std::filesystem::path(name).stem().string();
    map.path = name;
    map.sh_degree = harmonics.degree;
    map.notes.push_back("read as a compressed PLY of degree " + std::to_string(map.sh_degree));
    for (auto const& element : header.elements)
        if (&element != &vertex && &element != chunk && (&element != sh || harmonics.degree == 0) && map.notes.size() <= named_in_notes)
            map.notes.push_back("element " + in_quotes(element.name) + ": " + std::to_string(element.count) + " rows skipped");
    if (harmonics.degree < harmonics.file_degree)
        map.notes.push_back("view-dependent colour of degree " + std::to_string(harmonics.file_degree) + " read up to degree " +
                            std::to_string(harmonics.degree));
    if (vertex.count == 0) map.notes.push_back("element \"vertex\" has no rows: the map is empty");

    if (header.antialiased) map.notes.push_back(antialiased_note);
    MapSink sink(map, vertex.count, 0);
    std::vector<CompressedPly::Chunk> boxes;
    boxes.reserve(static_cast<std::size_t>(chunks));
    std::array<float, 256> coefficient_of{};
    for (std::uint32_t byte = 0; byte < 256; ++byte) coefficient_of[byte] = CompressedPly::coefficient(byte);
    std::size_t next = 0; // the first record that has no harmonics yet
    GaussianRow row{};
    auto const keep_chunk = [&](std::uint64_t, GaussianRow const& values) {
        CompressedPly::Chunk& out = boxes.emplace_back();
        for (std::size_t i = 0; i < box.size(); ++i) out[i] = static_cast<float>(values[i]);
    };
    auto const keep_vertex = [&](std::uint64_t number, GaussianRow const& values) {
        std::array<std::uint32_t, 4> words;
        for (std::size_t i = 0; i < 4; ++i) words[i] = static_cast<std::uint32_t>(values[i]);
        CompressedPly::unpack(words, boxes[static_cast<std::size_t>((number - 1) / CompressedPly::chunk_rows)], coloured, row);
        if (auto* const g = sink.add(number, row, false)) g->opacity = static_cast<float>(static_cast<double>(words[3] & 255u) / 255.0);
    };
    auto const keep_harmonics = [&](std::uint64_t number, GaussianRow const& values) {
        if (next == map.gaussians.size() || static_cast<std::uint64_t>(map.gaussians[next].id) != number) return; // the row is rejected
        ++next;
        for (std::size_t i = 0; i < coefficients.size(); ++i) map.harmonics.push_back(coefficient_of[static_cast<std::size_t>(values[i])]);
    };
    auto const read = [&](auto&& rows) {
        for (auto const& element : header.elements) {
            if (&element == chunk) rows.read(element, box, keep_chunk);
            else if (&element == &vertex) rows.read(element, packed, keep_vertex);
            else if (&element == sh && harmonics.degree != 0) rows.read(element, coefficients, keep_harmonics);
            else rows.skip(element);
        }
    };
    if (header.format == PlyFormat::little_endian) read(BinaryRows<std::endian::little>(source, file));
    else read(BinaryRows<std::endian::big>(source, file));
    sink.finish();
    if (source.left() != 0) map.notes.push_back(std::to_string(source.left()) + " bytes after the last row skipped");
    return map;
}

}}} // namespace tilemesh::v0_2::scene::detail
TILEMESH_EXACT_END
