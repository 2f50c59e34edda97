#pragma once
#include <filesystem>
#include <string>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/whole_file.hpp>

namespace shared {

/// The picture as the bytes of an 8-bit RGB PNG (`report::rgb8`).
std::string png_bytes(tilemesh::report::Image const& image);

/// Writes the picture as `png_bytes`, whole or not at all (`report::write_whole`); it is encoded in memory. Throws `tilemesh::Error` if it
/// cannot be written.
void write_png(std::filesystem::path const& path, tilemesh::report::Image const& image,
               tilemesh::report::Outlasts outlasts = tilemesh::report::Outlasts::process);

} // namespace shared
