#pragma once
#include <filesystem>
#include <tilemesh/report/image.hpp>

namespace render_map {

/// Writes the picture as an 8-bit RGB PNG (`report::rgb8`), whole or not at all: encoded in memory, written to
/// "<name>.part", renamed. Throws `tilemesh::Error` when it cannot be written; then no file is left behind.
void write_png(std::filesystem::path const& path, tilemesh::report::Image const& image);

} // namespace render_map
