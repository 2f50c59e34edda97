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
    double count = -1, bands = 0; ///< -1: the file does not say how many entries the palette has; 0: nor its degree
    bool there = false;
};

/// meta.json of an SOG map.
struct SogMeta {
    std::uint32_t version = 1;
    std::uint64_t count = 0;
    bool antialiased = false; ///< trained with anti-aliasing
    SogPart means, scales, quats, sh0, harmonics;

    /// A part shN without pictures is that of a map without harmonics. Its pictures count, not its `bands`: writers leave `bands` out or at 0.
    bool has_harmonics() const { return harmonics.there && !harmonics.files.empty(); }
    /// The names of the pictures that are read.
    TILEMESH_HOST std::vector<std::string> pictures() const;
};

/// Reads meta.json. Throws `Error` for JSON that is not the meta.json of a version that is read, for lists of more than 256 numbers or 2
/// files, and for a part without what the version needs. The message names the key, for example "scales.codebook".
///
/// Version 1 has no number. A file without a number whose scales have a codebook is of version 2, because only version 2 has codebooks.
/// Keys of other writers: `palette_size` for the `count` of shN, and `means.shape` for a missing `count` of a version 2.
/// Anti-aliasing: `antialias` or `antialiased` is true, or `model` is "antialiased", in the object itself or in `asset`.
///
/// The first entry of a codebook may be null. Published files have it, from a writer whose clusters became NaN when a map had too few
/// different values. The reader that these files were published for, PlayCanvas' engine, puts c[1] + (c[1] - c[255]) / 255 there, a step of
/// the list below c[1]; so does this one. A null at another place is refused: no reader gives it a value.
class SogMetaReader {
public:
    SogMetaReader(std::istream& stream, std::string const& file) : file_(file), json_(stream, file, "name an SOG map, or export it again") {}

    TILEMESH_HOST SogMeta read();

private:
    [[noreturn]] TILEMESH_HOST void refuse(std::string const& why) const;

    /// `name` is the part's key.
    TILEMESH_HOST void read_part(SogPart& out, std::string const& name);
    /// A list of numbers, or one number.
    TILEMESH_HOST void read_numbers(std::vector<double>& out, JsonPart part, std::string const& key);
    /// Reads the value of a key that may say that the map was trained with anti-aliasing.
    TILEMESH_HOST void read_antialiasing(bool& found, std::string const& key, JsonPart part);

    TILEMESH_HOST void check(SogMeta const& meta) const;

    std::string const& file_;
    JsonReader json_;
};

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/sog_meta_code.hpp>
#endif
