#pragma once
#include "map_writers.hpp"
#include <cstdlib>
#include <string>
#include <utility>
#if defined(TILEMESH_HAS_ZLIB)
#include <tilemesh/scene/codec_zlib.hpp>
#endif
#if defined(TILEMESH_HAS_ZSTD)
#include <tilemesh/scene/codec_zstd.hpp>
#endif
#if defined(TILEMESH_HAS_WEBP)
#include <tilemesh/scene/codec_webp.hpp>
#include <webp/encode.h>
#endif

// Compression by the libraries that CMake found, and by the stand-ins for the others.
namespace scene_test {

#if defined(TILEMESH_HAS_ZLIB)
inline Bytes deflate_with(int window_bits, Bytes const& in)
{
    z_stream stream{};
    if (deflateInit2(&stream, 6, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY) != Z_OK) std::abort();
    Bytes out(deflateBound(&stream, static_cast<uLong>(in.size())) + 64, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(in.data()));
    stream.avail_in = static_cast<uInt>(in.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    if (deflate(&stream, Z_FINISH) != Z_STREAM_END) std::abort();
    out.resize(out.size() - stream.avail_out);
    deflateEnd(&stream);
    return out;
}
#endif

inline Packing real_packing()
{
    Packing packing;
#if defined(TILEMESH_HAS_ZLIB)
    tilemesh::scene::add_zlib(packing.codecs);
    packing.gzip = +[](Bytes const& in) { return deflate_with(31, in); };
    packing.deflate = +[](Bytes const& in) { return deflate_with(-15, in); };
#endif
#if defined(TILEMESH_HAS_ZSTD)
    tilemesh::scene::add_zstd(packing.codecs);
    packing.zstd = +[](Bytes const& in) {
        Bytes out(ZSTD_compressBound(in.size()), '\0');
        std::size_t const size = ZSTD_compress(out.data(), out.size(), in.data(), in.size(), 3);
        if (ZSTD_isError(size) != 0) std::abort();
        out.resize(size);
        return out;
    };
#endif
#if defined(TILEMESH_HAS_WEBP)
    tilemesh::scene::add_webp(packing.codecs);
    packing.webp = +[](std::uint32_t width, std::uint32_t height, Bytes const& rgba) {
        WebPConfig config;
        WebPPicture picture;
        WebPMemoryWriter writer;
        if (!WebPConfigInit(&config) || !WebPPictureInit(&picture)) std::abort();
        WebPMemoryWriterInit(&writer);
        config.lossless = config.exact = 1; // a pixel without alpha keeps its colour
        config.method = 0;
        config.quality = 0;
        picture.use_argb = 1;
        picture.width = static_cast<int>(width);
        picture.height = static_cast<int>(height);
        picture.writer = WebPMemoryWrite;
        picture.custom_ptr = &writer;
        if (!WebPPictureImportRGBA(&picture, reinterpret_cast<std::uint8_t const*>(rgba.data()), static_cast<int>(4 * width)) || !WebPEncode(&config, &picture))
            std::abort();
        Bytes const out(reinterpret_cast<char const*>(writer.mem), writer.size);
        WebPPictureFree(&picture);
        WebPMemoryWriterClear(&writer);
        return out;
    };
#endif
    return packing;
}

} // namespace scene_test
