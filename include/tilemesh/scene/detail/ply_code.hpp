#pragma once
#include <algorithm>
#include <bit>
#include <cstddef>
#include <limits>
#include <tilemesh/scene/detail/far_means.hpp>
#include <tilemesh/scene/detail/map_sink.hpp>
#include <tilemesh/scene/detail/ply_compressed.hpp>
#include <tilemesh/scene/detail/ply_gaussian.hpp>
#include <tilemesh/scene/detail/ply_header.hpp>
#include <tilemesh/scene/detail/ply_kind.hpp>
#include <tilemesh/scene/detail/ply_rows.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/ply.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <utility>

namespace tilemesh { inline namespace v0_2 { namespace scene {

namespace detail {

inline std::string note_on_rest(PlyHarmonics const& found)
{
    auto const degree = [](std::uint32_t d) { return "view-dependent colour of degree " + std::to_string(d); };
    if (found.degree != 0 && found.degree < found.file_degree)
        return degree(found.file_degree) + " (" + std::to_string(found.columns) + " columns f_rest_*) read up to degree " +
               std::to_string(found.degree);
    if (found.file_degree != 0)
        return degree(found.file_degree) + " (" + std::to_string(found.columns) +
               " columns f_rest_*) skipped (they are not numbers f_rest_0 to f_rest_" + std::to_string(found.columns - 1) + ")";
    return std::to_string(found.columns) + " columns f_rest_* skipped (they fit no degree of view-dependent colour: 9, 24, 45)";
}

/// Adds a note for each part of the file that is not used.
inline void note_skipped(PlyHeader const& header, PlyElement const& vertex, PlyColumns const& columns, PlyHarmonics const& harmonics, Map& map)
{
    std::uint64_t elements = 0, others = 0;
    for (auto const& element : header.elements)
        if (&element != &vertex && ++elements <= named_in_notes)
            map.notes.push_back("element " + in_quotes(element.name) + ": " + std::to_string(element.count) + " rows skipped");
    if (elements > named_in_notes) map.notes.push_back("and " + std::to_string(elements - named_in_notes) + " more elements skipped");

    std::string names;
    for (auto const& property : vertex.properties) {
        if (std::find(columns.begin(), columns.end(), &property) != columns.end()) continue;
        if (!property.name.starts_with("f_rest_") && ++others <= 2 * named_in_notes)
            names.append(names.empty() ? "" : ", ").append(shown(property.name, 40));
    }
    if (harmonics.columns != 0 && (harmonics.degree == 0 || harmonics.degree < harmonics.file_degree)) map.notes.push_back(note_on_rest(harmonics));
    if (others > 2 * named_in_notes) names += " and " + std::to_string(others - 2 * named_in_notes) + " more";
    if (others != 0) map.notes.push_back("columns skipped: " + names);
    if (header.antialiased || vertex.find("filter_3D") != nullptr) map.notes.push_back(antialiased_note);
    if (vertex.count == 0) map.notes.push_back("element \"vertex\" has no rows: the map is empty");
}

} // namespace detail

namespace detail {

/// Reads one of `parts` parts of the rows of a PLY that is not compressed. `cut_off`, if it is not null, gets what float32 cuts off the means, if the
/// columns have more digits.
inline MapPart read_rows_of_ply(ByteSource& source, PlyHeader const& header, PlyElement const& vertex, std::string const& name,
                                std::string const& file, std::uint64_t part, std::uint64_t parts, CutOff* cut_off = nullptr)
{
    PlyColumns columns = find_columns(vertex, file);
    PlyHarmonics const harmonics = find_harmonics(vertex, columns);
    require_rows(header, source.left(), file);
    require_ids(vertex.count, file);

    MapPart out;
    Map& map = out.map;
    map.name = std::filesystem::path(name).stem().string();
    map.path = name;
    map.sh_degree = harmonics.degree;
    note_skipped(header, vertex, columns, harmonics, map);
    auto const head = map.notes.size();
    auto const start_of = [&](std::uint64_t p) { return vertex.count / parts * p + vertex.count % parts * p / parts; };
    std::uint64_t const first = start_of(part), last = start_of(part + 1);
    MapSink sink(map, last - first, splat::harmonics_per_channel(harmonics.file_degree));
    if (cut_off != nullptr && std::any_of(columns.begin(), columns.begin() + 3,
                                          [](PlyProperty const* p) { return p->type >= PlyType::int32 && p->type != PlyType::float32; }))
        sink.keep_cut_off(*cut_off);
    auto const keep = [&](std::uint64_t number, GaussianRow const& row) {
        if (number > first && number <= last) sink.add(number, row);
    };
    auto const read = [&](auto&& rows) {
        for (auto const& element : header.elements)
            if (&element == &vertex) rows.read(element, columns, keep, first, last);
            else rows.skip(element);
    };
    bool open_end = false;
    switch (header.format) {
    case PlyFormat::little_endian:
        read(BinaryRows<std::endian::little>(source, file));
        break;
    case PlyFormat::big_endian:
        read(BinaryRows<std::endian::big>(source, file));
        break;
    case PlyFormat::ascii:
        AsciiRows rows(source, file, header.lines);
        read(rows);
        open_end = rows.open_end();
        rows.find_row(); // blank lines at the end
        break;
    }
    out.rejected.assign(map.notes.begin() + static_cast<std::ptrdiff_t>(head), map.notes.end());
    map.notes.resize(head);
    if (open_end) out.last_notes.push_back("the last line has no end: its last number may be cut off");
    if (source.left() != 0) out.last_notes.push_back(std::to_string(source.left()) + " bytes after the last row skipped");
    return out;
}

} // namespace detail

TILEMESH_HOST Map read_ply(std::istream& stream, std::string const& name, FarMeans far)
{
    std::string const file = detail::shown(name, name.size());
    detail::ByteSource source(stream, file);
    detail::require_ply(source, file);
    detail::PlyHeader const header = detail::read_ply_header(source, file);
    detail::PlyElement const& vertex = detail::require_vertex(header, file);
    detail::CutOff cut_off;
    Map map = vertex.find("packed_position")
                  ? detail::read_compressed_ply(source, header, vertex, name)
                  : with_all_notes(detail::read_rows_of_ply(source, header, vertex, name, file, 0, 1, far == FarMeans::moved ? &cut_off : nullptr));
    detail::settle_far_means(map, far, cut_off);
    return map;
}

TILEMESH_HOST std::optional<MapPart> read_ply_part(std::istream& stream, std::string const& name, std::uint64_t part, std::uint64_t parts)
{
    std::string const file = detail::shown(name, name.size());
    detail::ByteSource source(stream, file);
    if (!source.begins_with("ply")) return {};
    detail::require_ply(source, file);
    detail::PlyHeader const header = detail::read_ply_header(source, file);
    detail::PlyElement const& vertex = detail::require_vertex(header, file);
    if (vertex.find("packed_position")) return {};
    return detail::read_rows_of_ply(source, header, vertex, name, file, part, parts);
}

TILEMESH_HOST std::optional<MapPart> load_ply_part(std::filesystem::path const& path, std::uint64_t part, std::uint64_t parts)
{
    auto stream = detail::open_file(path, std::numeric_limits<std::uint64_t>::max(), "a 3DGS map");
    return read_ply_part(stream, path.string(), part, parts);
}

TILEMESH_HOST Map with_all_notes(MapPart part)
{
    auto& notes = part.map.notes;
    auto const named = std::min<std::size_t>(part.rejected.size(), detail::named_in_notes);
    notes.insert(notes.end(), part.rejected.begin(), part.rejected.begin() + static_cast<std::ptrdiff_t>(named));
    if (part.map.rejected > named) notes.push_back("and " + std::to_string(part.map.rejected - named) + " more rows rejected");
    notes.insert(notes.end(), part.last_notes.begin(), part.last_notes.end());
    return std::move(part.map);
}

TILEMESH_HOST Map load_ply(std::filesystem::path const& path, FarMeans far)
{
    auto stream = detail::open_file(path, std::numeric_limits<std::uint64_t>::max(), "a 3DGS map");
    return read_ply(stream, path.string(), far);
}

}}} // namespace tilemesh::scene
