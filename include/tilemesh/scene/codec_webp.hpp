#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <tilemesh/scene/codecs.hpp>
#include <webp/decode.h>

namespace tilemesh { inline namespace v0_2 { namespace scene {

/// Fills in the decoder of libwebp. Link it: `-lwebp`; its package in Debian is libwebp-dev.
inline void add_webp(Codecs& codecs)
{
    codecs.webp_size = +[](std::span<unsigned char const> in) {
        int width = 0, height = 0;
        if (WebPGetInfo(in.data(), in.size(), &width, &height) == 0) return Codecs::Size{};
        return Codecs::Size{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)}; // 1 to 16,383
    };
    codecs.webp_read = +[](std::span<unsigned char const> in, std::span<unsigned char> rgba) {
        int width = 0, height = 0;
        if (WebPGetInfo(in.data(), in.size(), &width, &height) == 0) return false;
        return rgba.size() == 4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height) &&
               WebPDecodeRGBAInto(in.data(), in.size(), rgba.data(), rgba.size(), 4 * width) != nullptr;
    };
}

}}} // namespace tilemesh::scene
