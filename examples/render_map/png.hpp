#pragma once
#include <filesystem>
#include <tilemesh/report/image.hpp>

namespace render_map {

/// Writes the picture as an 8-bit RGB PNG (`report::rgb8`), whole or not at all (`report::write_whole`): it is encoded in memory.
/// Throws `tilemesh::Error` when it cannot be written.
void write_png(std::filesystem::path const& path, tilemesh::report::Image const& image);

} // namespace render_map
