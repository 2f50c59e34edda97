#include "png.hpp"
#include <cstddef>
#include <cstdlib>
#include <new>
#include <string>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/report/whole_file.hpp>

namespace {
/// realloc for stb. Out of memory, stb itself would end the process or write through the null pointer. This function loses the encoder's
/// memory, and the program ends with one line.
void* reallocate(void* old, std::size_t bytes)
{
    if (auto* const memory = std::realloc(old, bytes)) return memory;
    throw std::bad_alloc();
}
} // namespace

// The only translation unit that contains stb. Debian and others keep its headers in their own folder.
#define STBIW_MALLOC(bytes) reallocate(nullptr, static_cast<std::size_t>(bytes))
#define STBIW_REALLOC(old, bytes) reallocate(old, static_cast<std::size_t>(bytes))
#define STBIW_FREE(memory) std::free(memory)
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#if __has_include(<stb/stb_image_write.h>)
#include <stb/stb_image_write.h>
#else
#include <stb_image_write.h>
#endif

std::string render_map::png_bytes(tilemesh::report::Image const& image)
{
    auto const rgb = tilemesh::report::rgb8(image);
    std::string png;
    auto const append = [](void* to, void* data, int size) {
        static_cast<std::string*>(to)->append(static_cast<char const*>(data),
                                              static_cast<std::size_t>(size));
    };
    if (stbi_write_png_to_func(append, &png, static_cast<int>(image.width),
                               static_cast<int>(image.height), 3, rgb.data(),
                               static_cast<int>(3 * image.width)) == 0)
        throw std::bad_alloc();
    return png;
}

void render_map::write_png(std::filesystem::path const& path, tilemesh::report::Image const& image, tilemesh::report::Outlasts outlasts)
{
    tilemesh::report::write_whole(path, png_bytes(image), {}, outlasts);
}
