#pragma once
#include <istream>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/scene/codecs.hpp>
#include <tilemesh/scene/map.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// Reads a map in Niantic's SPZ format from a stream that can seek, from its current position to its end. `name` is the name in messages.
/// Versions 1 to 3 are compressed by gzip, or not compressed; version 4 has a zstd stream for each attribute.
///
/// The values are those of Niantic's own reader (spz, load-spz.cc), in its float32 operations:
/// - the mean: 24 bits of fixed point, exact (version 1: float16);
/// - the colour: `f_dc = (byte / 255 - 0.5) / 0.15`, then as by `read_ply`;
/// - the opacity: byte / 255, without that reader's way through a logarithm and back;
/// - the scales: byte / 16 - 10, exact;
/// - the rotation: x, y, z in 8 bits (versions 1 and 2) or the three smallest of four in 10 bits, then normalised;
/// - harmonics of degree 1 to 3: (byte - 128) / 128, exact. Degree 4 is read up to degree 3, with a note.
///
/// SPZ has x right, y up, z back. A PLY has x right, y down, z forward. The map gets the axes of a PLY, as Niantic's spz_to_ply writes it: y
/// and z change sign, with the rotations and harmonics. The notes say so; `turned` undoes it (Turn x180). If the extension
/// SPZ_ADOBE_coordinate_system names other axes, they are turned, or mirrored, to those of a PLY in the same way.
///
/// Rows are rejected, counted and named as by `read_ply`. Other extensions and the flag of anti-aliasing are noted, and not applied. Throws `Error`
/// for another kind of file, another version, a body that is shorter than its header promises, a damaged stream, a missing decoder,
/// and for more than 65,536 rows plus one a byte of the file (no map compresses so well).
///
/// Cost: 60 bytes a Gaussian (96, 156 or 240 with harmonics), the file, and its 19 to 65 (92) decompressed bytes a Gaussian. The length of
/// the file bounds the memory, not its header.
TILEMESH_HOST Map read_spz(std::istream& stream, std::string const& name, Codecs const& codecs);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/spz_code.hpp>
#endif
