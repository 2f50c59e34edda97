#pragma once
#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <istream>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <utility>
#include <vector>

namespace tilemesh::scene::detail {

enum class PlyType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

inline constexpr std::uint32_t size_of(PlyType type)
{
    constexpr std::array<std::uint32_t, 8> bytes{1, 1, 2, 2, 4, 4, 4, 8};
    return bytes[static_cast<std::size_t>(type)];
}

struct PlyProperty {
    std::string name;
    PlyType type;
    std::uint64_t offset; ///< bytes from the start of the row
};

struct PlyElement {
    std::string name;
    std::uint64_t count;     ///< as promised: it may be anything
    std::uint64_t row_bytes; ///< at most the header's length times 8
    std::vector<PlyProperty> properties;

    PlyProperty const* find(std::string_view property) const
    {
        auto const at = std::find_if(properties.begin(), properties.end(),
                                     [&](PlyProperty const& p) { return p.name == property; });
        return at == properties.end() ? nullptr : &*at;
    }
};

struct PlyHeader {
    std::vector<PlyElement> elements;
    std::uint64_t bytes = 0; ///< where the body begins
};

/// Words of a file in an error text: at most 40 characters, printable ones only, so that the text
/// stays one line.
inline std::string in_quotes(std::string_view text)
{
    std::string out = "\"";
    for (char c : text.substr(0, 40)) out += c >= ' ' && c <= '~' ? c : '?';
    return out + (text.size() > 40 ? "...\"" : "\"");
}

inline std::vector<std::string_view> words_of(std::string_view line)
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

/// The type of a name, in both spellings that are in use; false where there is none.
inline bool find_type(std::string_view name, PlyType& type)
{
    constexpr std::array<std::pair<std::string_view, PlyType>, 16> names{{
        {"char", PlyType::int8},
        {"int8", PlyType::int8},
        {"uchar", PlyType::uint8},
        {"uint8", PlyType::uint8},
        {"short", PlyType::int16},
        {"int16", PlyType::int16},
        {"ushort", PlyType::uint16},
        {"uint16", PlyType::uint16},
        {"int", PlyType::int32},
        {"int32", PlyType::int32},
        {"uint", PlyType::uint32},
        {"uint32", PlyType::uint32},
        {"float", PlyType::float32},
        {"float32", PlyType::float32},
        {"double", PlyType::float64},
        {"float64", PlyType::float64},
    }};
    for (auto const& [known, value] : names)
        if (name == known) {
            type = value;
            return true;
        }
    return false;
}

/// Reads the header of a binary little-endian PLY whose elements have scalar properties. Throws
/// `Error`, which begins with `file` and names the line, for everything else. Reads at most 256
/// KiB: real headers have 2 KiB.
inline PlyHeader read_ply_header(std::istream& stream, std::string const& file)
{
    constexpr std::uint64_t most_bytes = 1u << 18;
    PlyHeader header;
    std::string line;
    std::uint64_t number = 0;
    bool format_seen = false;

    auto const refuse = [&](std::string const& why) {
        throw Error(file + " has a header that cannot be read (line " + std::to_string(number) +
                    ": " + why + "); export the map again as binary_little_endian PLY");
    };
    auto const next_line = [&] {
        line.clear();
        for (int c; (c = stream.get()) != std::istream::traits_type::eof();) {
            ++header.bytes;
            if (c == '\n') {
                ++number;
                return true;
            }
            if (header.bytes >= most_bytes) return false;
            line += static_cast<char>(c);
        }
        return false;
    };

    // The magic word is asked for before anything else is looked at: a picture or an archive has no
    // lines.
    std::array<char, 3> magic{};
    stream.read(magic.data(), 3);
    if (stream.gcount() != 3 || std::string_view(magic.data(), 3) != "ply")
        throw Error(file + " is not a PLY file (it does not begin with \"ply\"); name a 3DGS map");
    header.bytes = 3;
    if (!next_line() || !words_of(line).empty())
        throw Error(file + " is not a PLY file (its first line is not \"ply\"); name a 3DGS map");

    while (true) {
        if (!next_line())
            throw Error(
                file + " has no end_header (the header is cut off or longer than 256 KiB); copy or "
                       "export the map again");
        auto const words = words_of(line);
        if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
        if (words[0] == "end_header") break;

        if (words[0] == "format") {
            if (words.size() < 2) refuse("a format without a name");
            if (words[1] == "ascii")
                throw Error(file +
                            " is an ASCII PLY (only binary_little_endian is read so far); export "
                            "the map as binary_little_endian");
            if (words[1] == "binary_big_endian")
                throw Error(file +
                            " is a big-endian PLY (only binary_little_endian is read so far); "
                            "export the map as binary_little_endian");
            if (words[1] != "binary_little_endian") refuse("unknown format " + in_quotes(words[1]));
            format_seen = true;
        } else if (words[0] == "element") {
            if (words.size() != 3) refuse("an element needs a name and a count");
            PlyElement element{std::string(words[1]), 0, 0, {}};
            auto const [end, error] =
                std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count);
            if (error != std::errc{} || end != words[2].data() + words[2].size())
                refuse("the count " + in_quotes(words[2]) + " is not a whole number below 2^64");
            for (auto const& other : header.elements)
                if (other.name == element.name)
                    refuse("element " + in_quotes(words[1]) + " comes twice");
            header.elements.push_back(std::move(element));
        } else if (words[0] == "property") {
            if (header.elements.empty()) refuse("a property before the first element");
            PlyElement& element = header.elements.back();
            if (words.size() > 1 && words[1] == "list")
                throw Error(file + " has a list property (line " + std::to_string(number) +
                            ", element " + in_quotes(element.name) +
                            "; only scalar properties are read so far); export the map without it");
            if (words.size() != 3) refuse("a property needs a type and a name");
            PlyProperty property{std::string(words[2]), PlyType::int8, element.row_bytes};
            if (!find_type(words[1], property.type)) refuse("unknown type " + in_quotes(words[1]));
            if (element.find(words[2])) refuse("property " + in_quotes(words[2]) + " comes twice");
            element.row_bytes += size_of(property.type);
            element.properties.push_back(std::move(property));
        } else {
            refuse("unknown word " + in_quotes(words[0]));
        }
    }
    if (!format_seen) refuse("there is no format line");
    return header;
}

} // namespace tilemesh::scene::detail
