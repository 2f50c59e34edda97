#include "png.hpp"
#include <cerrno>
#include <cstddef>
#include <fstream>
#include <string>
#include <system_error>
#include <tilemesh/error.hpp>
#include <tilemesh/report/image_file.hpp>

// The one translation unit that holds stb; Debian and others keep its headers in a folder of their own.
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#if __has_include(<stb/stb_image_write.h>)
#include <stb/stb_image_write.h>
#else
#include <stb_image_write.h>
#endif

void render_map::write_png(std::filesystem::path const& path, tilemesh::report::Image const& image)
{
    auto const fail = [&](std::string const& why) {
        throw tilemesh::Error("cannot write " + path.string() + " (" + why +
                              "); name a writable place with room for the pictures");
    };
    auto const rgb = tilemesh::report::rgb8(image);
    std::string png;
    auto const append = [](void* to, void* data, int size) {
        static_cast<std::string*>(to)->append(static_cast<char const*>(data),
                                              static_cast<std::size_t>(size));
    };
    if (stbi_write_png_to_func(append, &png, static_cast<int>(image.width),
                               static_cast<int>(image.height), 3, rgb.data(),
                               static_cast<int>(3 * image.width)) == 0)
        fail("the PNG encoder has no memory");

    auto part = path;
    part += ".part";
    std::error_code ignored;
    errno = 0;
    std::ofstream out(part, std::ios::binary | std::ios::trunc);
    out.write(png.data(), static_cast<std::streamsize>(png.size()));
    out.close();
    if (!out) {
        auto const why = std::generic_category().message(errno != 0 ? errno : EIO);
        std::filesystem::remove(part, ignored);
        fail(why);
    }
    std::error_code refused;
    std::filesystem::rename(part, path, refused);
    if (refused) {
        std::filesystem::remove(part, ignored);
        fail(refused.message());
    }
}
