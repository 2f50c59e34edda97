#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <vector>

/// Pictures in files. PFM keeps every bit of the linear floats; PPM and `rgb8` are for eyes.
///
/// A file is written whole or not at all; `Outlasts` says whether it survives a power loss: see `write_whole`.

namespace tilemesh { inline namespace v0_2 { namespace report {
/// The picture as 8-bit RGB, row by row from the top left, 3 * width * height bytes: the span that
/// PNG encoders take. Each value is clamped to [0, 1], times 255, rounded to nearest (halves up); a
/// NaN becomes 0.
///
/// Linear values are written as they are: 3DGS maps are trained on display values, so no gamma is
/// applied.
TILEMESH_HOST std::vector<std::byte> rgb8(Image const& image);

/// Binary PPM (P6, 8 bits a channel) of `rgb8`: the file that every viewer opens. Throws
/// `tilemesh::Error` for a picture without pixels and when the file cannot be written; then no file
/// is left behind.
TILEMESH_HOST void write_ppm(std::filesystem::path const& path, Image const& image);

/// Portable float map ("PF"): linear RGB float32, every bit as in the picture.
///
/// Throws `tilemesh::Error` for a picture without pixels and when the file cannot be written; then
/// no file is left behind.
TILEMESH_HOST void write_pfm(std::filesystem::path const& path, Image const& image, Outlasts outlasts = Outlasts::process);

/// Portable float map of one float a pixel ("Pf"), under the same rules.
TILEMESH_HOST void write_pfm(std::filesystem::path const& path, Plane const& plane, Outlasts outlasts = Outlasts::process);

/// A colour PFM of either byte order with scale 1 or -1. Values are taken as they are, infinities
/// and NaN too: the error measures refuse those.
///
/// Throws `tilemesh::Error` when the file cannot be read, is grey ("Pf"), has another scale, or is
/// not exactly as long as its header says; nothing is allocated before that length was checked.
TILEMESH_HOST Image read_pfm(std::filesystem::path const& path);

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/image_file_code.hpp>
#endif
