#pragma once
#include <istream>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/scene/map.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// Reads a map in antimatter15's .splat format from a stream that can seek, from its current position to its end. `name` is the name in
/// messages. A row has 32 bytes, little-endian; the file has no header:
/// - the mean, 3 floats;
/// - the scales, 3 floats: the map stores their logarithm (a scale of 0 is -87, as in `read_ply`);
/// - red, green, blue and opacity, a byte each: value / 255;
/// - the rotation w, x, y, z, a byte each: (byte - 128) / 128, then normalised.
/// These are the values of antimatter15's viewer, rounded to float32 once.
///
/// Rows are rejected, counted and named as by `read_ply`. Throws `Error` for a file that is empty or ends inside a row.
///
/// Cost: 60 bytes a Gaussian and 1 MiB. The length of the file bounds the memory.
TILEMESH_HOST Map read_splat(std::istream& stream, std::string const& name);

}}} // namespace tilemesh::scene

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/splat_file_code.hpp>
#endif
