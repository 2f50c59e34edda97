#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <tilemesh/config.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// The decoders that a program has for maps in compressed files. The library has none of its own: fill in those of zlib, libzstd and libwebp
/// with `add_zlib`, `add_zstd` and `add_webp` (scene/codec_zlib.hpp, codec_zstd.hpp, codec_webp.hpp; each needs its library). A reader
/// refuses a file whose decoder is null, and names the package. PLY and .splat need none.
struct Codecs {
    /// What a decompressor did.
    struct Result {
        std::size_t bytes = 0; ///< written to `out`, at most its size
        bool ended = false;    ///< the stream ended with these bytes, and its checksum is right
        bool more = false;     ///< `out` is full, and the stream goes on
        bool damaged = false;  ///< the stream breaks its format, or its checksum is wrong
    };
    /// Decompresses the stream at the beginning of `in` until `out` is full or the stream ends. `in` may end early: then
    /// `ended`, `more` and `damaged` are false.
    using Decompress = Result(std::span<unsigned char const> in, std::span<unsigned char> out);

    struct Size {
        std::uint32_t width = 0, height = 0; ///< 0: not a picture
    };
    /// The size of a picture, from its header.
    using PictureSize = Size(std::span<unsigned char const> in);
    /// Decodes a picture into 4 bytes a pixel, red, green, blue and alpha (not premultiplied), row by row from the top. `rgba` has its size.
    /// Returns false for a damaged picture.
    using PictureRead = bool(std::span<unsigned char const> in, std::span<unsigned char> rgba);
    /// The CRC-32 of ISO 3309, as ZIP has it.
    using Checksum = std::uint32_t(std::span<unsigned char const> in);

    Decompress* gzip = nullptr;    ///< RFC 1952: SPZ of versions 1 to 3 (zlib)
    Decompress* deflate = nullptr; ///< RFC 1951: entries of a ZIP archive (zlib)
    Checksum* crc32 = nullptr;     ///< of an entry of a ZIP archive (zlib)
    Decompress* zstd = nullptr;    ///< RFC 8878: SPZ of version 4 (libzstd)
    PictureSize* webp_size = nullptr;
    PictureRead* webp_read = nullptr; ///< the pictures of SOG (libwebp)
};

}}} // namespace tilemesh::scene
