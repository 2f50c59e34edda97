#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tilemesh/error.hpp>
#include <tilemesh/number_text.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

enum class PlyFormat : std::uint8_t { ascii, little_endian, big_endian };
enum class PlyType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

inline constexpr std::uint32_t size_of(PlyType type)
{
    constexpr std::array<std::uint32_t, 8> bytes{1, 1, 2, 2, 4, 4, 4, 8};
    return bytes[static_cast<std::size_t>(type)];
}

struct PlyProperty {
    std::string name;
    PlyType type;                      ///< of the number, or of a list's items
    std::uint64_t offset;              ///< bytes from the start of a binary row; has no meaning after a list
    std::optional<PlyType> count_type; ///< of a list's count; an integer

    bool is_list() const { return count_type.has_value(); }
};

struct PlyElement {
    std::string name;
    std::uint64_t count;     ///< as the header promises; it may be any number
    std::uint64_t row_bytes; ///< of a binary row whose lists are all empty; below the header's size
    bool has_lists;
    std::vector<PlyProperty> properties;

    PlyProperty const* find(std::string_view property) const
    {
        auto const at = std::find_if(properties.begin(), properties.end(), [&](PlyProperty const& p) { return p.name == property; });
        return at == properties.end() ? nullptr : &*at;
    }
};

struct PlyHeader {
    PlyFormat format = PlyFormat::ascii;
    std::vector<PlyElement> elements;
    std::uint64_t lines = 0;
    /// A comment says that the map was trained with anti-aliasing: "antialiased 1" (Postshot), or "SplatRenderMode: mip" (Brush). The last
    /// such comment counts.
    bool antialiased = false;
};

/// The fewest bytes that a row takes. In ASCII: one digit and one blank or line end for each property. The last line end of a file may be
/// missing.
inline std::uint64_t least_row_bytes(PlyElement const& element, PlyFormat format)
{
    return format == PlyFormat::ascii ? 2 * element.properties.size() : element.row_bytes;
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

/// The type of a name, in both spellings that are in use.
inline std::optional<PlyType> find_type(std::string_view name)
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

/// Reads the header of a PLY and leaves the source at its body. Throws `Error` for any other header; the message begins with `file` and
/// names the line. It reads at most 256 KiB; real headers have 2 KiB. Cost: n log n in its lines.
class PlyHeaderReader {
public:
    PlyHeaderReader(ByteSource& source, std::string const& file) : source_(source), file_(file) {}

    PlyHeader read()
    {
        if (!next_line() || words_of(line_).size() != 1 || words_of(line_)[0] != "ply")
            throw Error(file_ + " is not a PLY file (its first line is not \"ply\"); name a 3DGS map");
        bool format_seen = false;
        while (true) {
            if (!next_line())
                throw Error(file_ + " has no end_header (the header is cut off or longer than 256 KiB); copy or export the map "
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

private:
    using Words = std::vector<std::string_view>;

    [[noreturn]] void refuse(std::string const& why) const
    {
        throw Error(file_ + " has a header that cannot be read (line " + std::to_string(header_.lines) + ": " + why +
                    "); export the map again as binary_little_endian PLY");
    }
    bool next_line()
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
    void add_comment(Words const& words)
    {
        if (words.size() != 3) return;
        if (words[1] == "antialiased") header_.antialiased = words[2] == "1" || words[2] == "true";
        if (words[1] == "SplatRenderMode:") header_.antialiased = words[2] == "mip";
    }
    void add_format(Words const& words)
    {
        if (words.size() < 2) refuse("a format without a name");
        if (words[1] == "ascii") header_.format = PlyFormat::ascii;
        else if (words[1] == "binary_little_endian") header_.format = PlyFormat::little_endian;
        else if (words[1] == "binary_big_endian") header_.format = PlyFormat::big_endian;
        else refuse("unknown format " + in_quotes(words[1]));
    }
    void add_element(Words const& words)
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
    void add_property(Words const& words)
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
    PlyType type_of(std::string_view name) const
    {
        auto const type = find_type(name);
        if (!type) refuse("unknown type " + in_quotes(name));
        return *type;
    }

    ByteSource& source_;
    std::string const& file_;
    PlyHeader header_;
    std::string line_;
    std::uint64_t bytes_ = 0;
    std::set<std::string> element_names_, property_names_;
};

inline PlyHeader read_ply_header(ByteSource& source, std::string const& file)
{
    return PlyHeaderReader(source, file).read();
}

}}} // namespace tilemesh::v0_2::scene::detail
