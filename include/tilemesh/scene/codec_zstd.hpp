#pragma once
#include <cstddef>
#include <memory>
#include <new>
#include <span>
#include <tilemesh/scene/codecs.hpp>
#include <zstd.h>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// Fills in the decoder of libzstd. Link it: `-lzstd`; its package in Debian is libzstd-dev. A frame whose window is larger than 128 MiB is
/// damaged (the library's own limit).
inline void add_zstd(Codecs& codecs)
{
    codecs.zstd = +[](std::span<unsigned char const> in, std::span<unsigned char> out) {
        std::unique_ptr<ZSTD_DStream, std::size_t (*)(ZSTD_DStream*)> const stream(ZSTD_createDStream(), ZSTD_freeDStream);
        if (!stream) throw std::bad_alloc();
        ZSTD_inBuffer source{in.data(), in.size(), 0};
        Codecs::Result result;
        unsigned char behind = 0;
        while (true) {
            std::size_t const room = out.size() - result.bytes, taken = source.pos;
            ZSTD_outBuffer target{room != 0 ? out.data() + result.bytes : &behind, room != 0 ? room : 1, 0};
            std::size_t const code = ZSTD_decompressStream(stream.get(), &target, &source);
            result.more = room == 0 && target.pos != 0;
            if (result.more) return result;
            result.bytes += target.pos;
            result.ended = code == 0;
            result.damaged = ZSTD_isError(code) != 0;
            if (result.ended || result.damaged || (target.pos == 0 && source.pos == taken)) return result;
        }
    };
}

}}} // namespace tilemesh::scene
