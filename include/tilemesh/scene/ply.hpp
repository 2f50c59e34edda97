#pragma once
#include <cstdint>
#include <filesystem>
#include <istream>
#include <optional>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/scene/map.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// Reads a 3DGS map from a stream that can seek, from its current position to its end. `name` is the name in messages. The format is PLY:
/// ASCII, or binary in either byte order. The needed properties of element `vertex` are found by name, in any order and of any scalar type.
///
/// The map stores for each row:
/// - the mean;
/// - the colour `0.28209479 f_dc + 0.5`, clamped at 0 from below (not clamped if the map has harmonics);
/// - the sigmoid of `opacity`;
/// - `scale_*` unchanged, but at least -87;
/// - `rot_0..3` = w, x, y, z, normalised;
/// - harmonics of degree 1 to 3 (`f_rest_*`: 9, 24 or 45 columns).
///
/// PlayCanvas' compressed PLY (properties `packed_*` in chunks of 256 rows; not in ASCII) has the values of splat-transform's reader, in
/// double and rounded to float32 as it rounds them; the opacity is byte / 255, without that reader's way through a logarithm and back. A note
/// says so.
///
/// A note says that a map was trained with anti-aliasing, if the header says so: `comment antialiased 1`, `comment SplatRenderMode: mip`, or a
/// column `filter_3D` (Mip-Splatting).
///
/// Other properties and other elements, including lists, are skipped, with a note. A file without rows gives an empty map, with a note.
///
/// A row that is not finite or has a zero quaternion is left out and counted. The notes name the first five such rows, numbered from 1 as
/// the ids are. An infinite `opacity` and a `scale` of -infinity are valid. An ASCII row is one line. If the last line has no line end, a
/// note says so, because its last number may be cut off. Throws `Error` for another kind of file (it names the kind if it knows it), and
/// for a body that is shorter than its header promises.
///
/// Cost: 60 bytes a Gaussian (96, 156 or 240 with harmonics) and 1 MiB, in every format; the stream is read once. The length of the file
/// bounds the memory, not its header: at most 60 bytes for 14 bytes of the file (240 for 59).
///
/// `far` says what happens to means that are far from 0 against their spread (`detail::far_origin`). Columns of type double keep their digits when
/// the means are moved; then the cost is 12 bytes a Gaussian more.
TILEMESH_HOST Map read_ply(std::istream& stream, std::string const& name, FarMeans far = FarMeans::kept);

/// `read_ply` for a file. It opens only regular files, because a pipe or a device could block. Throws `Error` for any other path, and if
/// the file cannot be opened.
TILEMESH_HOST Map load_ply(std::filesystem::path const& path, FarMeans far = FarMeans::kept);

/// A part of the rows of a map, for one of several processes.
struct MapPart {
    Map map;                             ///< the rows of this part, with their ids in the whole map. Its notes are about the whole file
    std::vector<std::string> rejected;   ///< a note on each of the first five rows of this part that are rejected
    std::vector<std::string> last_notes; ///< on the end of the file; the last of a map's notes
};

/// Reads part `part` of `parts` equal parts of a PLY's rows, counted before rows are rejected. Parts differ by at most one row. Every part has
/// the header; the parts together have the rows of `read_ply`. Returns nothing, and leaves the stream anywhere, for a file that cannot be read
/// in parts: a compressed PLY, or another kind of file.
///
/// Throws `Error` as `read_ply`, but for the rows of other parts. Cost: it reads the header and the part. Of an ASCII file, or if an element
/// up to the rows has lists, it reads all rows, and stores those of the part. Far means stay as they are, because a part does not know the others.
TILEMESH_HOST std::optional<MapPart> read_ply_part(std::istream& stream, std::string const& name, std::uint64_t part, std::uint64_t parts);

/// `read_ply_part` for a file, as `load_ply`.
TILEMESH_HOST std::optional<MapPart> load_ply_part(std::filesystem::path const& path, std::uint64_t part, std::uint64_t parts);

/// The map of a part, with all notes in the order of `read_ply`. To join the notes of several parts, add up `map.rejected`, and put
/// `rejected` of all parts one behind the other. Only the first five are used.
TILEMESH_HOST Map with_all_notes(MapPart part);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/ply_code.hpp>
#endif
