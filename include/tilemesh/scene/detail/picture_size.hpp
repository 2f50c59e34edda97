#pragma once
#include <filesystem>
#include <istream>
#include <optional>
#include <tilemesh/config.hpp>
#include <tilemesh/scene/pose.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// The size that the header of a PNG or JPEG says; nothing for any other content, and for a side outside 1..65535. It reads no pixel. Of a
/// JPEG it walks over the segments before the frame (JPEG, B.1.1.4 and B.2.2), at most 1 MiB: pictures of cameras have previews there.
TILEMESH_HOST std::optional<Size> picture_size(std::istream& stream);

/// `picture_size` of a regular file; nothing for any other path, because a pipe or a device could block.
TILEMESH_HOST std::optional<Size> size_of_picture_file(std::filesystem::path const& path);

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/picture_size_code.hpp>
#endif
