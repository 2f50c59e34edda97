#pragma once
#include <string>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/scene/rgbd_list.hpp>

namespace shared {

/// A picture and its depths in world units. A depth that is not known is 0; without a depth file the plane is empty.
struct RgbdPhoto {
    tilemesh::report::Image colour;
    tilemesh::report::Plane depth;
};

/// The pictures of a recording.
std::vector<std::filesystem::path> pictures_of(std::vector<tilemesh::scene::RgbdFrame> const& list);

/// The size of a frame's picture. Throws `tilemesh::Error` for a file that is no picture.
tilemesh::scene::Size size_of(tilemesh::scene::RgbdFrame const& frame);

/// Reads the picture of a frame, PNG or JPEG, and its depth, a grey PNG of 16 bits with `levels` levels a world unit; level 0 is not
/// known, and level 65535 is not either, because programs write it for what they do not know or cannot say. A pixel that is not opaque, or that
/// the frame's mask leaves out (`apply_mask`), is NaN, with a depth that is not known.
///
/// Throws `tilemesh::Error` for a file that cannot be read, has another size than `size`, or is no such depth, and for depths whose bytes
/// are swapped (`has_swapped_bytes`). `or_else` is what a user may do in place of giving a depth: ", or use --no-depth".
RgbdPhoto read_photo(tilemesh::scene::RgbdFrame const& frame, tilemesh::scene::Size size, double levels, std::string const& or_else);

} // namespace shared
