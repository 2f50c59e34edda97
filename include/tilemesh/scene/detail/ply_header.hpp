#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
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

    TILEMESH_HOST PlyProperty const* find(std::string_view property) const;
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
TILEMESH_HOST std::uint64_t least_row_bytes(PlyElement const& element, PlyFormat format);

TILEMESH_HOST std::vector<std::string_view> words_of(std::string_view line);

/// The type of a name, in both spellings that are in use.
TILEMESH_HOST std::optional<PlyType> find_type(std::string_view name);

/// Reads the header of a PLY and leaves the source at its body. Throws `Error` for any other header; the message begins with `file` and
/// names the line. It reads at most 256 KiB; real headers have 2 KiB. Cost: n log n in its lines.
class PlyHeaderReader {
public:
    PlyHeaderReader(ByteSource& source, std::string const& file) : source_(source), file_(file) {}

    TILEMESH_HOST PlyHeader read();

private:
    using Words = std::vector<std::string_view>;

    [[noreturn]] TILEMESH_HOST void refuse(std::string const& why) const;
    TILEMESH_HOST bool next_line();
    TILEMESH_HOST void add_comment(Words const& words);
    TILEMESH_HOST void add_format(Words const& words);
    TILEMESH_HOST void add_element(Words const& words);
    TILEMESH_HOST void add_property(Words const& words);
    TILEMESH_HOST PlyType type_of(std::string_view name) const;

    ByteSource& source_;
    std::string const& file_;
    PlyHeader header_;
    std::string line_;
    std::uint64_t bytes_ = 0;
    std::set<std::string> element_names_, property_names_;
};

TILEMESH_HOST PlyHeader read_ply_header(ByteSource& source, std::string const& file);

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/ply_header_code.hpp>
#endif
