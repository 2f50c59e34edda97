#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/scene/detail/ply_header.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

TILEMESH_HOST auto PlyElement::find(std::string_view property) const -> PlyProperty const*
{
    auto const at =
        std::find_if(properties.begin(), properties.end(), [&](PlyProperty const& p) { return p.name == property; });
    return at == properties.end() ? nullptr : &*at;
}

TILEMESH_HOST std::uint64_t least_row_bytes(PlyElement const& element, PlyFormat format)
{
    return format == PlyFormat::ascii ? 2 * element.properties.size() : element.row_bytes;
}

TILEMESH_HOST std::vector<std::string_view> words_of(std::string_view line)
{
    std::vector<std::string_view> words;
    while (true) {
        std::size_t const begin = line.find_first_not_of(" \t\r");
        if (begin == std::string_view::npos) return words;
        line.remove_prefix(begin);
        words.push_back(line.substr(0, line.find_first_of(" \t\r")));
        line.remove_prefix(words.back().size());
    }
}

TILEMESH_HOST std::optional<PlyType> find_type(std::string_view name)
{
    constexpr std::array<std::array<std::string_view, 2>, 8> names{{{"char", "int8"},
                                                                    {"uchar", "uint8"},
                                                                    {"short", "int16"},
                                                                    {"ushort", "uint16"},
                                                                    {"int", "int32"},
                                                                    {"uint", "uint32"},
                                                                    {"float", "float32"},
                                                                    {"double", "float64"}}};
    for (std::size_t i = 0; i < names.size(); ++i)
        if (name == names[i][0] || name == names[i][1]) return static_cast<PlyType>(i);
    return std::nullopt;
}

TILEMESH_HOST auto PlyHeaderReader::read() -> PlyHeader
{
    if (!next_line() || words_of(line_).size() != 1 || words_of(line_)[0] != "ply")
        throw Error(file_ + " is not a PLY file (its first line is not \"ply\"); name a 3DGS map");
    bool format_seen = false;
    while (true) {
        if (!next_line())
            throw Error(file_ +
                        " has no end_header (the header is cut off or longer than 256 KiB); copy or export the map "
                        "again");
        auto const words = words_of(line_);
        if (words.empty()) continue;
        if (words[0] == "comment" || words[0] == "obj_info") {
            add_comment(words);
            continue;
        }
        if (words[0] == "end_header") break;
        if (words[0] == "format") {
            if (format_seen) refuse("a second format");
            format_seen = true;
            add_format(words);
        } else if (words[0] == "element") {
            add_element(words);
        } else if (words[0] == "property") {
            add_property(words);
        } else {
            refuse("unknown word " + in_quotes(words[0]));
        }
    }
    if (!format_seen) refuse("there is no format line");
    return std::move(header_);
}

TILEMESH_HOST void PlyHeaderReader::refuse(std::string const& why) const
{
    throw Error(file_ + " has a header that cannot be read (line " + std::to_string(header_.lines) + ": " + why +
                "); export the map again as binary_little_endian PLY");
}

TILEMESH_HOST bool PlyHeaderReader::next_line()
{
    constexpr std::uint64_t most_bytes = 1u << 18;
    line_.clear();
    for (int c; bytes_ < most_bytes && (c = source_.get()) >= 0;) {
        ++bytes_;
        if (c == '\n') {
            ++header_.lines;
            return true;
        }
        line_ += static_cast<char>(c);
    }
    return false;
}

TILEMESH_HOST void PlyHeaderReader::add_comment(Words const& words)
{
    if (words.size() != 3) return;
    if (words[1] == "antialiased") header_.antialiased = words[2] == "1" || words[2] == "true";
    if (words[1] == "SplatRenderMode:") header_.antialiased = words[2] == "mip";
}

TILEMESH_HOST void PlyHeaderReader::add_format(Words const& words)
{
    if (words.size() < 2) refuse("a format without a name");
    if (words[1] == "ascii") header_.format = PlyFormat::ascii;
    else if (words[1] == "binary_little_endian") header_.format = PlyFormat::little_endian;
    else if (words[1] == "binary_big_endian") header_.format = PlyFormat::big_endian;
    else refuse("unknown format " + in_quotes(words[1]));
}

TILEMESH_HOST void PlyHeaderReader::add_element(Words const& words)
{
    if (words.size() != 3) refuse("an element needs a name and a count");
    PlyElement element{std::string(words[1]), 0, 0, false, {}};
    auto const count = number_of<std::uint64_t>(words[2]);
    if (!count) refuse("the count " + in_quotes(words[2]) + " is not a whole number below 2^64");
    element.count = *count;
    if (!element_names_.insert(element.name).second) refuse("element " + in_quotes(words[1]) + " comes twice");
    property_names_.clear();
    header_.elements.push_back(std::move(element));
}

TILEMESH_HOST void PlyHeaderReader::add_property(Words const& words)
{
    if (header_.elements.empty()) refuse("a property before the first element");
    PlyElement& element = header_.elements.back();
    bool const list = words.size() > 1 && words[1] == "list";
    if (words.size() != (list ? 5u : 3u))
        refuse(list ? "a list needs the type of its count, a type and a name" : "a property needs a type and a name");
    auto const type = type_of(words[words.size() - 2]);
    PlyProperty property{std::string(words.back()), type, element.row_bytes, std::nullopt};
    if (list) {
        property.count_type = type_of(words[2]);
        if (*property.count_type >= PlyType::float32) refuse("the count of a list is no integer type");
        element.has_lists = true;
    }
    if (!property_names_.insert(property.name).second) refuse("property " + in_quotes(words.back()) + " comes twice");
    element.row_bytes += size_of(property.count_type.value_or(type));
    element.properties.push_back(std::move(property));
}

TILEMESH_HOST auto PlyHeaderReader::type_of(std::string_view name) const -> PlyType
{
    auto const type = find_type(name);
    if (!type) refuse("unknown type " + in_quotes(name));
    return *type;
}

TILEMESH_HOST PlyHeader read_ply_header(ByteSource& source, std::string const& file)
{
    return PlyHeaderReader(source, file).read();
}

}}} // namespace tilemesh::scene
