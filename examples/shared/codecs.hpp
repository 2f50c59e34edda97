#pragma once
#include <tilemesh/scene/codecs.hpp>
#if defined(TILEMESH_HAS_ZLIB)
#include <tilemesh/scene/codec_zlib.hpp>
#endif
#if defined(TILEMESH_HAS_ZSTD)
#include <tilemesh/scene/codec_zstd.hpp>
#endif
#if defined(TILEMESH_HAS_WEBP)
#include <tilemesh/scene/codec_webp.hpp>
#endif

namespace shared {

/// The decoders of the libraries that CMake found.
inline tilemesh::scene::Codecs codecs()
{
    tilemesh::scene::Codecs all;
#if defined(TILEMESH_HAS_ZLIB)
    tilemesh::scene::add_zlib(all);
#endif
#if defined(TILEMESH_HAS_ZSTD)
    tilemesh::scene::add_zstd(all);
#endif
#if defined(TILEMESH_HAS_WEBP)
    tilemesh::scene::add_webp(all);
#endif
    return all;
}

} // namespace shared
