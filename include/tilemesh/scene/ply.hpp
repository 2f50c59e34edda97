#pragma once
#include <filesystem>
#include <istream>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/scene/map.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// Reads a 3DGS map from a stream that can seek, from where it stands to its end: a PLY, ASCII or binary in either order of
/// bytes, the needed properties of element `vertex` found by name, in any order and of any scalar type. `name` is what
/// messages call it. Stored are: the mean; colour `0.28209479 f_dc + 0.5`, clamped at 0 from below; the sigmoid of `opacity`;
/// `scale_*` as it is, but not below -87; `rot_0..3` = w, x, y, z, normalised; harmonics of degree 1 to 3 (`f_rest_*`: 9, 24 or
/// 45 columns), the colour then unclamped. Other properties and other elements, lists among them, are skipped, with a note. A
/// file without rows is an empty map, with a note.
///
/// Rows that are not finite or have a zero quaternion are left out and counted; the notes name the first five, numbered from 1
/// as the ids are. An infinite `opacity` and a `scale` of -infinity are values. An ASCII row is one line; a file may lack its
/// last line end; a note says so, because its last number may be cut off. Throws `Error` for another kind of file, and names the
/// kind where it is known; also for a body that is shorter than its header promises.
///
/// Cost: 60 bytes a Gaussian, with harmonics 96, 156 or 240, and 1 MiB, in every format; the stream is read once. The memory is
/// bounded by the length of the file, not by its header: at most 60 bytes for 14 of the file (240 for 59).
TILEMESH_HOST Map read_ply(std::istream& stream, std::string const& name);

/// `read_ply` of a file. Only regular files are opened, so that a pipe or a device cannot block; everything else, and what
/// cannot be opened, throws `Error`.
TILEMESH_HOST Map load_ply(std::filesystem::path const& path);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/ply_code.hpp>
#endif
