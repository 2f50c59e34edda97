#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <istream>
#include <optional>
#include <string_view>
#include <system_error>
#include <tilemesh/scene/pose.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// The size that the header of a PNG or JPEG says; nothing for any other content, and for a side outside 1..65535. It reads no pixel. Of a
/// JPEG it walks over the segments before the frame (JPEG, B.1.1.4 and B.2.2), at most 1 MiB: pictures of cameras have previews there.
inline std::optional<Size> picture_size(std::istream& stream)
{
    std::array<unsigned char, 24> bytes{};
    auto const read = [&](std::size_t n) {
        stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(n));
        return static_cast<std::size_t>(stream.gcount()) == n;
    };
    auto const number = [&](std::size_t at, std::size_t n) {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < n; ++i) value = value << 8 | bytes[at + i];
        return value;
    };
    auto const size_of = [](std::uint32_t width, std::uint32_t height) {
        bool const valid = width >= 1 && width <= 65535 && height >= 1 && height <= 65535;
        return valid ? std::optional(Size{width, height}) : std::nullopt;
    };
    if (!read(2)) return {};
    if (bytes[0] == 0x89 && bytes[1] == 'P') {
        if (!read(22)) return {};
        std::string_view const text(reinterpret_cast<char const*>(bytes.data()), 22);
        if (!text.starts_with("NG\r\n\x1a\n") || text.substr(10, 4) != "IHDR") return {};
        return size_of(number(14, 4), number(18, 4));
    }
    if (bytes[0] != 0xff || bytes[1] != 0xd8) return {};
    for (std::uint32_t passed = 0; passed < 1u << 20;) {
        if (!read(1) || bytes[0] != 0xff) return {};
        do {
            if (!read(1)) return {};
            ++passed;
        } while (bytes[0] == 0xff && passed < 1u << 20); // fill bytes
        std::uint32_t const marker = bytes[0];
        if (!read(2)) return {};
        std::uint32_t const length = number(0, 2);
        if (length < 2) return {};
        // SOF0 to SOF15, without DHT, JPG and DAC.
        if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc) {
            if (!read(5)) return {};
            return size_of(number(3, 2), number(1, 2));
        }
        stream.ignore(static_cast<std::streamsize>(length - 2));
        passed += length;
    }
    return {};
}

/// `picture_size` of a regular file; nothing for any other path, because a pipe or a device could block.
inline std::optional<Size> size_of_picture_file(std::filesystem::path const& path)
{
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) return {};
    std::ifstream stream(path, std::ios::binary);
    if (!stream) return {};
    return picture_size(stream);
}

}}} // namespace tilemesh::v0_2::scene::detail
