#pragma once
#include <filesystem>
#include <istream>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/scene/codecs.hpp>
#include <tilemesh/scene/map.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// Reads a map in PlayCanvas' SOG format, versions 1 and 2, from a ZIP archive: a stream that can seek, from its current position to its end.
/// `name` is the name in messages. The archive holds meta.json and the WebP pictures that it names, a pixel for each Gaussian.
///
/// The values are those of PlayCanvas' own reader (splat-transform), in double and rounded to float32 as it rounds them:
/// - the mean: 16 bits between `mins` and `maxs`, then sign(v) (e^|v| - 1);
/// - the rotation: the three smallest of w, x, y, z in 8 bits, then normalised;
/// - scales, colour `f_dc` and harmonics of degree 1 to 3: a byte each that picks a value of a list of 256 (version 1: a share of a range);
///   the harmonics are in a palette of at most 65,536 entries. `bands` is their degree; where it is missing or 0, the palette's width says
///   the degree, and a note says so. The first value of a list may be null (`detail::SogMetaReader` says what that means);
/// - the opacity: byte / 255, without that reader's way through a logarithm and back (version 1: the sigmoid of a share of a range).
/// A note says that a map was trained with anti-aliasing (`antialias` of meta.json).
/// The axes are those of the PLY that the file was made from: the format turns nothing.
///
/// Rows are rejected, counted and named as by `read_ply`; a rotation whose alpha names no component is rejected too. Throws `Error` for
/// another kind of file, another version, a missing entry, lossy pictures, pictures of other sizes than the number of Gaussians needs, a label
/// beyond the palette, damaged content, a missing decoder, and for more than 65,536 rows plus one a byte of the file.
///
/// Cost: 60 bytes a Gaussian (96, 156 or 240 with harmonics), the file, and about 24 bytes a Gaussian for the decoded pictures. The length
/// of the file bounds the memory, not its header.
TILEMESH_HOST Map read_sog(std::istream& stream, std::string const& name, Codecs const& codecs);

/// `read_sog` for a folder with meta.json and its pictures. `path` is the folder or its meta.json, of any name.
TILEMESH_HOST Map load_sog_folder(std::filesystem::path const& path, Codecs const& codecs);

/// The files that `load_sog_folder` reads: meta.json, and the pictures that it names. Reads only meta.json; throws `Error` if that cannot be
/// read.
TILEMESH_HOST std::vector<std::filesystem::path> sog_folder_files(std::filesystem::path const& path);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/sog_code.hpp>
#endif
