#pragma once
#include <array>
#include <filesystem>
#include <limits>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/pose.hpp>

namespace shared {

/// The size of a PNG or JPEG picture, from its header. Throws `tilemesh::Error` for a file that cannot be read, that is no regular file, or
/// that is no such picture, and for a header that is damaged (`header_damage`).
tilemesh::scene::Size picture_size(std::filesystem::path const& path);

/// What the header of a picture says beside its size: its first 64 KiB. Nothing, for a file that cannot be read.
struct PictureFacts {
    bool transparent = false; ///< pixels may be
    bool turned = false;      ///< an Exif orientation other than the one as stored; it is not applied
};
PictureFacts picture_facts(std::filesystem::path const& path);

/// The background of pictures that have none: a pixel that is not opaque becomes NaN, which is not known.
inline constexpr std::array<float, 3> no_background{std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::quiet_NaN(),
                                                    std::numeric_limits<float>::quiet_NaN()};

/// Decodes a PNG or JPEG picture of this size. Its levels become values from 0 to 1; grey becomes three equal channels; transparency shows
/// the background. Throws `tilemesh::Error` as `picture_size` does, and for a picture that has another size, is damaged (`picture_damage`)
/// or cannot be decoded. A PNG with one changed bit is refused, or the bit changes no pixel. A JPEG has no checksum: damage of its structure is
/// refused, another value is another picture.
///
/// Memory: the file and a few pictures of this size. A file that needs more is refused, whatever its header says.
tilemesh::report::Image read_picture(std::filesystem::path const& path, tilemesh::scene::Size size, std::array<float, 3> const& background);

} // namespace shared
