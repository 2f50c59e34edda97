#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <ios>
#include <limits>
#include <locale>
#include <span>
#include <sstream>
#include <string_view>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/report/image_file.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

namespace detail {

inline std::string last_system_error()
{
    return errno != 0 ? std::generic_category().message(errno) : "the stream failed";
}

inline void expect_pixels(Image const& image, std::string const& action)
{
    if (image.width == 0 || image.height == 0) throw Error("cannot " + action + " (the picture has no pixels); render a frame first");
    if (image.rgb.size() != std::size_t{3} * image.width * image.height)
        throw Error("cannot " + action + " (" + std::to_string(image.rgb.size()) +
                    " floats are not 3 x width x height); keep rgb in step with the size");
}

inline void store_float(float value, std::byte* to) noexcept
{
    auto const bits = __builtin_bit_cast(std::uint32_t, value);
    for (unsigned i = 0; i < 4; ++i) to[i] = static_cast<std::byte>(bits >> (8 * i) & 0xffu);
}

inline float load_float(std::byte const* from, std::endian order) noexcept
{
    std::uint32_t bits = 0;
    for (unsigned i = 0; i < 4; ++i) {
        auto const byte = from[order == std::endian::little ? i : 3 - i];
        bits |= std::to_integer<std::uint32_t>(byte) << (8 * i);
    }
    return __builtin_bit_cast(float, bits);
}

} // namespace detail

namespace detail {
/// Writes `channels` floats a pixel, rows from the bottom to the top as the format requires (Debevec's description, as in Netpbm's
/// `pfm(5)`), little endian (scale -1.0).
inline void write_rows_as_pfm(std::filesystem::path const& path, std::uint32_t width, std::uint32_t height,
                              std::uint32_t channels, std::span<float const> values, Outlasts outlasts)
{
    auto const header = (channels == 3 ? "PF\n" : "Pf\n") + std::to_string(width) + ' ' + std::to_string(height) + "\n-1.0\n";
    std::vector<std::byte> body(4 * values.size());
    auto* to = body.data();
    auto const row = std::size_t{channels} * width;
    for (std::size_t y = height; y-- > 0;)
        for (float value : values.subspan(y * row, row)) {
            store_float(value, to);
            to += 4;
        }
    write_whole(path, header, body, outlasts);
}
} // namespace detail

TILEMESH_HOST std::vector<std::byte> rgb8(Image const& image)
{
    std::vector<std::byte> bytes(image.rgb.size());
    std::transform(image.rgb.begin(), image.rgb.end(), bytes.begin(), [](float value) {
        // 255 v + 0.5 is exact in double, so no value is rounded to the wrong side of a half.
        double const clamped = value > 0.0f ? std::min(double{value}, 1.0) : 0.0;
        return static_cast<std::byte>(static_cast<unsigned>(255.0 * clamped + 0.5));
    });
    return bytes;
}

TILEMESH_HOST std::string bmp(Image const& image)
{
    detail::expect_pixels(image, "make a BMP file");
    if (std::max(image.width, image.height) > 65'535)
        throw Error("cannot make a BMP file (the picture has " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                    " pixels); choose sides of 1 to 65,535");
    auto const pixels = rgb8(image);
    std::size_t const row = (std::size_t{3} * image.width + 3) / 4 * 4;
    std::string out = "BM";
    auto const number = [&](std::uint64_t value, int bytes) {
        for (int i = 0; i < bytes; ++i) out += static_cast<char>(static_cast<unsigned char>(value >> (8 * i) & 0xffu));
    };
    number(54 + row * image.height, 4);      // a file header: its size, two words of 0, where the pixels begin
    number(0, 4);
    number(54, 4);
    number(40, 4);                           // a header of 40 bytes: the picture's size, one plane, 24 bits a pixel, not compressed,
    number(image.width, 4);
    number(image.height, 4);
    number(1, 2);
    number(24, 2);
    number(0, 4);
    number(row * image.height, 4);           // the size of the pixels, no size in metres, no palette
    for (int i = 0; i < 4; ++i) number(0, 4);
    for (std::uint32_t y = image.height; y-- > 0;) { // from the lowest row up, blue first
        auto const begin = out.size();
        for (std::size_t x = 0; x < image.width; ++x)
            for (std::size_t c = 3; c-- > 0;) out += static_cast<char>(pixels[3 * (std::size_t{y} * image.width + x) + c]);
        out.resize(begin + row, '\0');
    }
    return out;
}

TILEMESH_HOST void write_ppm(std::filesystem::path const& path, Image const& image)
{
    detail::expect_pixels(image, "write " + path.string());
    auto const header = "P6\n" + std::to_string(image.width) + ' ' + std::to_string(image.height) + "\n255\n";
    write_whole(path, header, rgb8(image));
}

TILEMESH_HOST void write_pfm(std::filesystem::path const& path, Image const& image, Outlasts outlasts)
{
    detail::expect_pixels(image, "write " + path.string());
    detail::write_rows_as_pfm(path, image.width, image.height, 3, image.rgb, outlasts);
}

TILEMESH_HOST void write_pfm(std::filesystem::path const& path, Plane const& plane, Outlasts outlasts)
{
    if (plane.empty() || plane.values.size() != std::size_t{plane.width} * plane.height)
        throw Error("cannot write " + path.string() + " (" + std::to_string(plane.values.size()) +
                    " floats are not width x height, or none); render with a setup whose pixels have this plane");
    detail::write_rows_as_pfm(path, plane.width, plane.height, 1, plane.values, outlasts);
}

TILEMESH_HOST Image read_pfm(std::filesystem::path const& path)
{
    auto const fail = [&](std::string const& why, std::string const& remedy) {
        throw Error("cannot read " + path.string() + " (" + why + "); " + remedy);
    };
    std::string const write_again = "write it again as a colour PFM";
    std::error_code refused;
    auto const size = std::filesystem::file_size(path, refused);
    if (refused) fail(refused.message(), "name a PFM file");
    errno = 0;
    std::ifstream in{path, std::ios::binary};
    if (!in && errno == ENOMEM) throw std::bad_alloc();
    if (!in) fail(detail::last_system_error(), "name a readable PFM file");

    // The longest header with two 10-digit sizes and a plain scale is far below 128 bytes.
    std::array<char, 128> head{};
    in.read(head.data(), static_cast<std::streamsize>(head.size()));
    if (in.bad()) fail(detail::last_system_error(), "name a readable PFM file");
    std::string const text(head.data(), static_cast<std::size_t>(in.gcount()));
    if (text.starts_with("Pf")) fail("a grey PFM, magic \"Pf\"", write_again);
    if (!text.starts_with("PF")) fail("no magic \"PF\": not a PFM file", "name a PFM file");

    std::istringstream header{text.substr(2)};
    header.exceptions(std::ios::badbit); // out of memory is not a bad header
    header.imbue(std::locale::classic());
    std::int64_t width = 0;
    std::int64_t height = 0;
    double scale = 0.0;
    header >> width >> height >> scale;
    // One white-space character ends the header. If it is missing, the file is cut short.
    if (!header || std::string_view{" \t\r\n"}.find(static_cast<char>(header.get())) == std::string_view::npos)
        fail("the header is not \"PF width height scale\"", write_again);
    constexpr std::int64_t largest = std::numeric_limits<std::uint32_t>::max();
    if (width < 1 || height < 1 || width > largest || height > largest)
        fail("its size is " + std::to_string(width) + " x " + std::to_string(height), write_again);
    if (!(std::abs(scale) == 1.0)) fail("its scale is " + std::to_string(scale) + ", only 1 and -1 are read", write_again);

    // Compare by division: width * height * 12 may not fit into 64 bits.
    auto const start = static_cast<std::uint64_t>(header.tellg()) + 2;
    auto const body = size >= start ? size - start : 0;
    auto const w = static_cast<std::uint64_t>(width);
    auto const h = static_cast<std::uint64_t>(height);
    if (body % 12 != 0 || body / 12 % w != 0 || body / 12 / w != h)
        fail("its " + std::to_string(body) + " bytes of pixels are not those of " + std::to_string(width) + " x " + std::to_string(height),
             "it is truncated or damaged: " + write_again);

    Image image{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
    std::vector<std::byte> row(std::size_t{12} * image.width);
    auto const order = scale < 0.0 ? std::endian::little : std::endian::big;
    in.clear();
    in.seekg(static_cast<std::streamoff>(start));
    for (std::uint32_t y = image.height; y-- > 0;) {
        in.read(reinterpret_cast<char*>(row.data()), static_cast<std::streamsize>(row.size()));
        if (!in) fail("it ends in row " + std::to_string(y), write_again);
        for (std::size_t i = 0; i < std::size_t{3} * image.width; ++i) image.pixel(0, y)[i] = detail::load_float(&row[4 * i], order);
    }
    return image;
}

}}} // namespace tilemesh::report
