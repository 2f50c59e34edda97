#include "picture_input.hpp"
#include "picture_check.hpp"
#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <type_traits>
#include <vector>

namespace {
/// What the decoder may allocate at once, and whether the system refused an allocation. A picture can claim to unpack to any size.
thread_local std::size_t most_bytes = 0;
thread_local bool out_of_memory = false;

void* allocate(void* old, std::size_t bytes)
{
    if (bytes > most_bytes) return nullptr;
    // New memory is zero. A damaged file may let the decoder read what it has not written: then every run reads the same.
    auto* const memory = old != nullptr ? std::realloc(old, bytes) : std::calloc(bytes, 1);
    out_of_memory = out_of_memory || memory == nullptr;
    return memory;
}
} // namespace

// The only translation unit that contains this decoder. Debian and others keep stb's headers in their own folder.
#define STBI_MALLOC(bytes) allocate(nullptr, static_cast<std::size_t>(bytes))
#define STBI_REALLOC(old, bytes) allocate(old, static_cast<std::size_t>(bytes))
#define STBI_FREE(memory) std::free(memory)
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_MAX_DIMENSIONS 65535
#define STBI_FAILURE_USERMSG
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#if __has_include(<stb/stb_image.h>)
#include <stb/stb_image.h>
#else
#include <stb_image.h>
#endif

namespace shared {

namespace {

namespace fs = std::filesystem;
using tilemesh::Error;

/// The decoder takes 2^30 bytes of pixels, and up to four channels.
constexpr std::uint64_t most_pixels = std::uint64_t{1} << 28;

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

/// Opens a regular file. A pipe could block.
File open_picture(fs::path const& path)
{
    std::error_code refused;
    auto const type = fs::status(path, refused).type();
    auto const fail = [&](std::string const& why) { throw Error(path.string() + " cannot be opened (" + why + "); name a PNG or JPEG file"); };
    if (type == fs::file_type::not_found) fail("no such file");
    if (type == fs::file_type::none) fail(refused.message());
    if (type != fs::file_type::regular) fail("it is no regular file");
    errno = 0;
    File file(std::fopen(path.c_str(), "rb"), std::fclose);
    if (!file && errno == ENOMEM) throw std::bad_alloc();
    if (!file) fail(std::generic_category().message(errno));
    return file;
}

std::uint64_t number_at(std::span<unsigned char const> bytes, std::size_t at, std::size_t count, bool little = false)
{
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < count; ++i) value = value << 8 | bytes[at + (little ? count - 1 - i : i)];
    return value;
}
bool has_text(std::span<unsigned char const> bytes, std::size_t at, std::string_view text)
{
    return at + text.size() <= bytes.size() && std::memcmp(bytes.data() + at, text.data(), text.size()) == 0;
}

/// The chunk of a PNG with this name before its first IDAT; empty if there is none. A chunk: its length, 4 letters, its bytes, a checksum (PNG
/// specification, sections 5.3 and 5.6). What the bytes given do not have is cut off.
std::span<unsigned char const> png_chunk(std::span<unsigned char const> bytes, std::string_view name)
{
    if (!has_text(bytes, 1, "PNG")) return {};
    for (std::size_t at = 8; at + 8 <= bytes.size() && !has_text(bytes, at + 4, "IDAT");) {
        auto const length = static_cast<std::size_t>(number_at(bytes, at, 4));
        if (has_text(bytes, at + 4, name)) return bytes.subspan(at, std::min(length + 12, bytes.size() - at));
        if (length > bytes.size()) break;
        at += 12 + length;
    }
    return {};
}
/// Has a PNG a transparent colour? The decoder's own question about channels does not look for it.
bool has_colour_key(std::span<unsigned char const> bytes) { return !png_chunk(bytes, "tRNS").empty(); }

/// Exif data: an IFD of TIFF, in either order of bytes, with 12 bytes an entry: tag, type, count, value (TIFF 6.0, section 2; Exif 2.3, 4.6.4 A:
/// tag 0x112, orientation, 1 to 8). 1 for what is cut off or is no such data.
std::uint64_t orientation(std::span<unsigned char const> tiff)
{
    bool const little = has_text(tiff, 0, {"II*\0", 4});
    if (!little && !has_text(tiff, 0, {"MM\0*", 4})) return 1;
    if (tiff.size() < 8) return 1;
    auto const ifd = static_cast<std::size_t>(number_at(tiff, 4, 4, little));
    if (ifd > tiff.size() || tiff.size() - ifd < 2) return 1;
    auto const entries = static_cast<std::size_t>(number_at(tiff, ifd, 2, little));
    for (std::size_t i = 0, at = ifd + 2; i < entries && at + 12 <= tiff.size(); ++i, at += 12)
        if (number_at(tiff, at, 2, little) == 0x112) return number_at(tiff, at + 8, 2, little);
    return 1;
}
/// The Exif data of a JPEG, in the first APP1 segment that begins with "Exif" (Exif 2.3, 4.7.2), or of a PNG (chunk eXIf); empty for none.
std::span<unsigned char const> exif_of(std::span<unsigned char const> bytes)
{
    if (auto const found = png_chunk(bytes, "eXIf"); found.size() > 8) return found.subspan(8);
    if (!has_text(bytes, 0, "\xff\xd8")) return {};
    for (std::size_t at = 2; at + 4 <= bytes.size() && bytes[at] == 0xff && bytes[at + 1] != 0xda;) {
        auto const length = static_cast<std::size_t>(number_at(bytes, at + 2, 2));
        if (bytes[at + 1] == 0xe1 && has_text(bytes, at + 4, {"Exif\0\0", 6}))
            return bytes.subspan(at + 10, std::min(std::max<std::size_t>(length, 8) - 8, bytes.size() - at - 10));
        at += 2 + std::max<std::size_t>(length, 2);
    }
    return {};
}

} // namespace

tilemesh::scene::Size picture_size(fs::path const& path)
{
    auto const file = open_picture(path);
    auto const fail = [&](std::string const& why) { throw Error(path.string() + " cannot be decoded (" + why + "); write it again as PNG or JPEG"); };
    if (auto const damage = header_damage(file.get()); !damage.empty()) fail(std::string(damage));
    std::rewind(file.get());
    most_bytes = std::size_t{1} << 20;
    int width = 0, height = 0, channels = 0;
    if (stbi_info_from_file(file.get(), &width, &height, &channels) == 0 || width < 1 || height < 1) {
        std::array<unsigned char, 24> begin{}; // of a PNG: up to its width and height, which `header_damage` has checked
        std::rewind(file.get());
        auto const read = std::fread(begin.data(), 1, begin.size(), file.get());
        if (read == begin.size() && has_text(begin, 1, "PNG")) {
            auto const across = number_at(begin, 16, 4), down = number_at(begin, 20, 4);
            auto const pixels = std::to_string(across) + " x " + std::to_string(down) + " pixels";
            if (across * down > most_pixels || across > STBI_MAX_DIMENSIONS || down > STBI_MAX_DIMENSIONS)
                throw Error(path.string() + " is too large to be read (it has " + pixels + "; a side may have " + std::to_string(STBI_MAX_DIMENSIONS) +
                            ", and a picture " + std::to_string(most_pixels) + "); write it smaller");
            fail("its header cannot be read, or is of no picture: " + pixels);
        }
        if (read == begin.size() && has_text(begin, 0, "version https://git-lfs"))
            throw Error(path.string() + " is a pointer of git LFS (the picture itself is not here); run git lfs pull");
        if (read > 1 && begin[0] == 0xff && begin[1] >= 0xd8) fail(std::string("its header cannot be read: ") + stbi_failure_reason());
        throw Error(path.string() + " is not a picture that is read (it is neither PNG nor JPEG); convert it to one of them");
    }
    return {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
}

PictureFacts picture_facts(fs::path const& path)
{
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored)) return {};
    File const file(std::fopen(path.c_str(), "rb"), std::fclose);
    std::vector<unsigned char> begin(std::size_t{1} << 16);
    begin.resize(file ? std::fread(begin.data(), 1, begin.size(), file.get()) : 0);
    // Bit 2 of the kind of colour is set for an alpha channel (PNG specification, 11.2.1).
    bool const alpha = begin.size() > 25 && has_text(begin, 1, "PNG") && (begin[25] & 4u) != 0;
    auto const turn = orientation(exif_of(begin));
    return {alpha || has_colour_key(begin), turn > 1 && turn <= 8};
}

tilemesh::report::Image read_picture(fs::path const& path, tilemesh::scene::Size size, std::array<float, 3> const& background)
{
    auto const fail = [&](std::string const& why) {
        throw Error(path.string() + " cannot be decoded (" + why + "); write it again as PNG or JPEG");
    };
    if (auto const own = picture_size(path); own.width != size.width || own.height != size.height) fail("its size has changed");
    auto const file = open_picture(path);
    auto const pixels = std::size_t{size.width} * size.height;
    // The largest useful file is a PNG of four 16-bit channels that does not shrink. 64 MiB: for what is not pixels.
    std::error_code refused;
    auto const length = fs::file_size(path, refused);
    if (refused || length > std::min<std::uintmax_t>(9 * pixels + (std::size_t{64} << 20), std::numeric_limits<int>::max())) fail("the file is too long for its " + std::to_string(pixels) + " pixels");
    std::vector<unsigned char> bytes(static_cast<std::size_t>(length));
    if (std::fread(bytes.data(), 1, bytes.size(), file.get()) != bytes.size()) fail("it cannot be read to its end");

    // A progressive JPEG of three channels keeps two bytes a coefficient in whole blocks of 16 x 16 pixels, a PNG eight bytes a pixel.
    most_bytes = 16 * (std::size_t{size.width} + 16) * (std::size_t{size.height} + 16) + (std::size_t{1} << 20);
    if (auto const damage = picture_damage(bytes, most_bytes); !damage.empty()) fail(std::string(damage));
    out_of_memory = false;
    auto const* const data = bytes.data();
    auto const count = static_cast<int>(bytes.size());
    int width = 0, height = 0, channels = 0;
    stbi_info_from_memory(data, count, &width, &height, &channels);
    bool const transparent = channels == 2 || channels == 4 || has_colour_key(bytes), deep = stbi_is_16_bit_from_memory(data, count) != 0;
    std::size_t const kept = transparent ? 4 : 3;
    auto const decode = [&](auto* levels, auto highest) {
        std::unique_ptr<std::remove_pointer_t<decltype(levels)>, void (*)(void*)> const owned(levels, std::free);
        if (!owned && out_of_memory) throw std::bad_alloc();
        if (!owned) fail(stbi_failure_reason());
        if (width != static_cast<int>(size.width) || height != static_cast<int>(size.height)) fail("its size has changed");
        tilemesh::report::Image image{size.width, size.height};
        for (std::size_t i = 0; i < pixels; ++i)
            for (std::size_t c = 0; c < 3; ++c) {
                float const cover = transparent ? static_cast<float>(levels[kept * i + 3]) / highest : 1.0f;
                image.rgb[3 * i + c] =
                    static_cast<float>(levels[kept * i + c]) / highest * cover + (cover < 1.0f ? (1.0f - cover) * background[c] : 0.0f);
            }
        return image;
    };
    if (deep) return decode(stbi_load_16_from_memory(data, count, &width, &height, &channels, static_cast<int>(kept)), 65535.0f);
    return decode(stbi_load_from_memory(data, count, &width, &height, &channels, static_cast<int>(kept)), 255.0f);
}

} // namespace shared
