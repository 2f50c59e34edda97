#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <tilemesh/scene/codecs.hpp>

// Decoders that decompress nothing, so that tests and fuzzers reach the readers behind them on every machine. A stream is: its first three
// bytes (of the format that it stands for), the length in 4 bytes, a sum in 4 bytes, then the content. A picture is: "WP", width and height
// in 2 bytes each, then its pixels.
namespace scene_test {

using Bytes = std::string;

inline void put_little(Bytes& out, std::uint64_t value, std::size_t n)
{
    for (std::size_t i = 0; i < n; ++i) out += static_cast<char>(value >> 8 * i & 255u);
}
inline std::uint64_t get_little(std::span<unsigned char const> in, std::size_t at, std::size_t n)
{
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < n; ++i) value |= std::uint64_t{in[at + i]} << 8 * i;
    return value;
}
inline std::uint32_t plain_sum(std::span<unsigned char const> in)
{
    std::uint32_t sum = 0;
    for (unsigned char c : in) sum = sum * 31 + c;
    return sum;
}
inline std::span<unsigned char const> view(Bytes const& bytes)
{
    return {reinterpret_cast<unsigned char const*>(bytes.data()), bytes.size()};
}

inline Bytes plain_pack(Bytes const& content, char const* magic = "\x1f\x8b\x08")
{
    Bytes out(magic, 3);
    put_little(out, content.size(), 4);
    put_little(out, plain_sum(view(content)), 4);
    return out + content;
}
/// With `checked` off, a wrong sum does not matter: a fuzzer never finds the right one. The sum of an entry of a ZIP archive is then always 0,
/// so an archive for a fuzzer has zeros there.
template <bool checked>
tilemesh::scene::Codecs::Result plain_unpack(std::span<unsigned char const> in, std::span<unsigned char> out)
{
    tilemesh::scene::Codecs::Result result;
    if (in.size() < 11) return result;
    std::size_t const length = get_little(in, 3, 4), there = std::min(length, in.size() - 11);
    result.bytes = std::min(there, out.size());
    std::copy_n(in.begin() + 11, result.bytes, out.begin());
    result.more = there > out.size();
    bool const whole = result.bytes == length;
    result.damaged = checked && whole && get_little(in, 7, 4) != plain_sum(in.subspan(11, length));
    result.ended = whole && !result.damaged;
    return result;
}

inline Bytes plain_picture(std::uint32_t width, std::uint32_t height, Bytes const& rgba)
{
    Bytes out = "WP";
    put_little(out, width, 2);
    put_little(out, height, 2);
    return out + rgba;
}

template <bool checked = true>
tilemesh::scene::Codecs plain_codecs()
{
    using tilemesh::scene::Codecs;
    Codecs codecs;
    codecs.gzip = codecs.deflate = codecs.zstd = plain_unpack<checked>;
    if constexpr (checked) codecs.crc32 = plain_sum;
    else codecs.crc32 = +[](std::span<unsigned char const>) { return std::uint32_t{0}; };
    codecs.webp_size = +[](std::span<unsigned char const> in) {
        if (in.size() < 6 || in[0] != 'W' || in[1] != 'P') return Codecs::Size{};
        return Codecs::Size{static_cast<std::uint32_t>(get_little(in, 2, 2)), static_cast<std::uint32_t>(get_little(in, 4, 2))};
    };
    codecs.webp_read = +[](std::span<unsigned char const> in, std::span<unsigned char> rgba) {
        if (in.size() - 6 < rgba.size()) return false;
        std::copy_n(in.begin() + 6, rgba.size(), rgba.begin());
        return true;
    };
    return codecs;
}

} // namespace scene_test
