#pragma once
#include <cstddef>
#include <cstdio>
#include <span>
#include <string_view>

namespace shared {

/// What is wrong with the header of a PNG or JPEG file, as far as its size is read from it: a damaged signature or header of a PNG, or a
/// Huffman table before a JPEG's size that is none. Empty if nothing is, also for a file of another kind. Reads from the file's beginning,
/// and leaves its position anywhere.
///
/// A decoder that does not look may write behind an array for a Huffman table of more than 256 codes. So this comes before any decoder.
std::string_view header_damage(std::FILE* file);

/// What is wrong with a PNG or JPEG file: that it is cut short, that a checksum of a PNG is wrong, or that a table is impossible. Empty if
/// nothing is found, also for a file of another kind.
///
/// PNG: the signature; the length and the CRC-32 of every chunk up to IEND, which must be there; and the compressed pixels, which are
/// unpacked for their Adler-32 (RFC 1950 and 1951). They may unpack to `most_bytes`. A change of any single bit up to IEND is found.
/// JPEG: the chain of segments up to the end marker, the Huffman tables, that a scan has the tables that it needs (a decoder may read an
/// array that nobody has filled), and that the codes of each scan make the frame's blocks, with restarts in order, and no more (jpeg_scan.hpp).
/// A JPEG has no checksum: a change of a value, or of a table's number, looks like another picture.
///
/// Cost: a pass over the file, and the time to unpack it once more; for a PNG a copy of the packed pixels and 40 KiB, for a progressive JPEG
/// 8 bytes a block.
std::string_view picture_damage(std::span<unsigned char const> bytes, std::size_t most_bytes);

} // namespace shared
