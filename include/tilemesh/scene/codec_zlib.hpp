#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <span>
#include <tilemesh/scene/codecs.hpp>
#include <zlib.h>

namespace tilemesh { inline namespace v0_2 { namespace scene {

namespace detail {

/// `window_bits`: as inflateInit2 takes it.
inline Codecs::Result inflate_with(int window_bits, std::span<unsigned char const> in, std::span<unsigned char> out)
{
    z_stream stream{};
    if (inflateInit2(&stream, window_bits) != Z_OK) throw std::bad_alloc();
    struct End {
        z_stream& stream;
        ~End() { inflateEnd(&stream); }
    } const end{stream};
    // A call counts in 32 bits. The byte behind `out` shows whether the stream goes on, and lets zlib see its end.
    constexpr std::size_t most = std::numeric_limits<uInt>::max();
    Codecs::Result result;
    std::size_t taken = 0;
    unsigned char behind = 0;
    while (true) {
        std::size_t const room = out.size() - result.bytes;
        stream.next_in = const_cast<unsigned char*>(in.data() + taken); // zlib does not write there
        stream.avail_in = static_cast<uInt>(std::min(in.size() - taken, most));
        stream.next_out = room != 0 ? out.data() + result.bytes : &behind;
        stream.avail_out = static_cast<uInt>(room != 0 ? std::min(room, most) : 1);
        uInt const in_before = stream.avail_in, out_before = stream.avail_out;
        int const code = inflate(&stream, Z_NO_FLUSH);
        std::size_t const read = in_before - stream.avail_in, written = out_before - stream.avail_out;
        taken += read;
        result.more = room == 0 && written != 0;
        if (result.more) return result;
        result.bytes += written;
        result.ended = code == Z_STREAM_END;
        result.damaged = code != Z_STREAM_END && code != Z_OK && code != Z_BUF_ERROR;
        if (code == Z_MEM_ERROR) throw std::bad_alloc();
        if (result.ended || result.damaged || (read == 0 && written == 0)) return result;
    }
}

} // namespace detail

/// Fills in the decoders of zlib. Link it: `-lz`; its package in Debian is zlib1g-dev.
inline void add_zlib(Codecs& codecs)
{
    codecs.gzip = +[](std::span<unsigned char const> in, std::span<unsigned char> out) { return detail::inflate_with(16 + MAX_WBITS, in, out); };
    codecs.deflate = +[](std::span<unsigned char const> in, std::span<unsigned char> out) { return detail::inflate_with(-MAX_WBITS, in, out); };
    codecs.crc32 = +[](std::span<unsigned char const> in) { return static_cast<std::uint32_t>(::crc32_z(0, in.data(), in.size())); };
}

}}} // namespace tilemesh::scene
