#pragma once
#include <filesystem>
#include <istream>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/scene/codecs.hpp>
#include <tilemesh/scene/map.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// Reads a map in any format that the library reads, from a stream that can seek, from its current position to its end. `name` is the name in
/// messages. The first bytes choose the reader, not the name: `read_ply` (also compressed PLY), `read_spz`, or `read_sog` for a ZIP archive.
/// A .splat map has no such bytes: a name that ends in .splat chooses `read_splat`. The notes of the map say what was read, unless it is a PLY.
///
/// Errors, memory and rejected rows: as the readers say. Throws `Error` for any other file, and names its kind if it knows it.
///
/// A note says that all opacities of a PLY are from 0 to 1, or all scales above 0: they may be linear, and are read as logits and logarithms.
///
/// `far` says what happens to means that are far from 0 against their spread, in every format (`detail::far_origin` has the rule).
TILEMESH_HOST Map read_map(std::istream& stream, std::string const& name, Codecs const& codecs = {}, FarMeans far = FarMeans::kept);

/// `read_map` for a file, or `load_sog_folder` for a folder with meta.json or for that file itself. It opens only regular files, because a
/// pipe or a device could block. Throws `Error` for any other path, and if the file cannot be opened.
TILEMESH_HOST Map load_map(std::filesystem::path const& path, Codecs const& codecs = {}, FarMeans far = FarMeans::kept);

/// Are the means far from 0 against their spread, so that `FarMeans::moved` moves them?
TILEMESH_HOST bool has_far_means(Map const& map);

/// The files that `load_map` reads: `path`, or of a folder of SOG its meta.json and the pictures that it names. Throws `Error` if `path` or
/// meta.json cannot be read.
TILEMESH_HOST std::vector<std::filesystem::path> map_files(std::filesystem::path const& path);

/// Joins maps into one, in their order. The ids of a map count on behind the rows of the map before, with rejected rows. The degree is the
/// highest of all; harmonics that a map does not have are zero. The joined map has the name and the origin of the first; the means of a
/// map with another origin move. With several maps, the notes begin
/// with the path that they are about. Throws `Error` if the rows of all maps do not fit 32 bits, and as `require_harmonics`. Cost: a copy of all
/// records.
TILEMESH_HOST Map join_maps(std::vector<Map> maps);

/// A right turn about an axis of the world: x180 changes the signs of y and z. Counter-clockwise, seen from the tip of the axis.
enum class Turn : unsigned char { x90, x180, x270, y90, y180, y270, z90, z180, z270 };

/// Turns a map about the origin of its file: means, rotations, harmonics and `Map::origin`. It looks from a turned camera as it did before. Means,
/// and harmonics of a turn by 180 degrees, are exact; other numbers are rounded to float32.
TILEMESH_HOST Map turned(Map map, Turn turn);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/map_file_code.hpp>
#endif
