#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/report/whole_file.hpp>
#include <vector>

/// Picture files. PFM keeps every bit of the linear floats. PPM and `rgb8` are for viewing.
///
/// A file is written whole or not at all. `Outlasts` says whether it survives a power loss (`write_whole`).

namespace tilemesh { inline namespace v0_2 { namespace report {
/// The picture as 8-bit RGB, row by row from the top left, 3 * width * height bytes: the span that PNG encoders take. Each value is clamped
/// to [0, 1], multiplied by 255, and rounded to the nearest integer (halves up). A NaN becomes 0.
///
/// No gamma is applied, because 3DGS maps are trained on display values.
TILEMESH_HOST std::vector<std::byte> rgb8(Image const& image);

/// Returns `rgb8` of the picture as a BMP file (24 bits a pixel), which browsers show: 54 bytes and 3 a pixel, rows of a multiple of 4 bytes.
/// Throws `tilemesh::Error` for a picture without pixels or with a side above 65,535.
TILEMESH_HOST std::string bmp(Image const& image);

/// Writes a binary PPM (P6, 8 bits a channel) of `rgb8`, a format that every viewer opens. Throws `tilemesh::Error` for a picture without
/// pixels and if the file cannot be written; then it leaves no file.
TILEMESH_HOST void write_ppm(std::filesystem::path const& path, Image const& image);

/// Writes a portable float map ("PF"): linear RGB float32, every bit as in the picture.
///
/// Throws `tilemesh::Error` for a picture without pixels and if the file cannot be written; then it leaves no file.
TILEMESH_HOST void write_pfm(std::filesystem::path const& path, Image const& image, Outlasts outlasts = Outlasts::process);

/// Writes a portable float map of one float a pixel ("Pf"), with the same errors.
TILEMESH_HOST void write_pfm(std::filesystem::path const& path, Plane const& plane, Outlasts outlasts = Outlasts::process);

/// Reads a colour PFM of either byte order with scale 1 or -1. It accepts all values, including infinities and NaN; the error measures
/// refuse those.
///
/// Throws `tilemesh::Error` if the file cannot be read, is grey ("Pf"), has another scale, or is not exactly as long as its header says. It
/// allocates nothing before it has checked that length.
TILEMESH_HOST Image read_pfm(std::filesystem::path const& path);

}}} // namespace tilemesh::report

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/report/detail/image_file_code.hpp>
#endif
