#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <istream>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/scene/detail/json_reader.hpp>
#include <tilemesh/scene/detail/ply_source.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// A part of meta.json of an SOG map: the pictures of an attribute and what their bytes mean.
struct SogPart {
    std::vector<double> mins, maxs, codebook, shape;
    std::vector<std::string> files;
    double count = 0, bands = 0;
    bool there = false;
};

/// meta.json of an SOG map.
struct SogMeta {
    std::uint32_t version = 1; ///< version 1 has no number
    std::uint64_t count = 0;
    SogPart means, scales, quats, sh0, harmonics;

    bool has_harmonics() const { return harmonics.there && (version == 1 || harmonics.bands > 0); }
    /// The names of the pictures that are read.
    TILEMESH_HOST std::vector<std::string> pictures() const;
};

/// Reads meta.json. Throws `Error` for JSON that is not the meta.json of a version that is read, for lists of more than 256 numbers or 2
/// files, and for a part without what the version needs.
class SogMetaReader {
public:
    SogMetaReader(std::istream& stream, std::string const& file) : file_(file), json_(stream, file, "name an SOG map, or export it again") {}

    TILEMESH_HOST SogMeta read();

private:
    [[noreturn]] TILEMESH_HOST void refuse(std::string const& why) const;

    TILEMESH_HOST void read_part(SogPart& out);
    /// A list of numbers, or one number.
    TILEMESH_HOST void read_numbers(std::vector<double>& out, JsonPart part);

    TILEMESH_HOST void check(SogMeta const& meta) const;

    std::string const& file_;
    JsonReader json_;
};

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#    include <tilemesh/scene/detail/sog_meta_code.hpp>
#endif
