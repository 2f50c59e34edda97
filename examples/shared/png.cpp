#include "png.hpp"
#include <cstddef>
#include <cstdlib>
#include <new>
#include <tilemesh/report/image_file.hpp>
#ifdef TILEMESH_HAS_DEFLATE
#    include <libdeflate.h>
#endif

namespace {
/// realloc for stb. Out of memory, stb itself would end the process or write through the null pointer. This function loses the encoder's
/// memory, and the program ends with one line.
void* reallocate(void* old, std::size_t bytes)
{
    if (auto* const memory = std::realloc(old, bytes)) return memory;
    throw std::bad_alloc();
}
#ifdef TILEMESH_HAS_DEFLATE
/// Deflates for stb, with libdeflate's fastest level that compresses. It takes half of the time of zlib's fastest level, which takes a fourth
/// of the time of stb's own encoder; files are a twentieth larger than those of zlib's level 1 with runs only.
unsigned char* deflated(unsigned char* data, int size, int* deflated_size, int)
{
    struct Compressor {
        libdeflate_compressor* by = libdeflate_alloc_compressor(1);
        ~Compressor() { libdeflate_free_compressor(by); }
    } const compressor;
    if (compressor.by == nullptr) throw std::bad_alloc();
    auto const bytes = static_cast<std::size_t>(size), room = libdeflate_zlib_compress_bound(compressor.by, bytes);
    auto* const to = static_cast<unsigned char*>(reallocate(nullptr, room));
    *deflated_size = static_cast<int>(libdeflate_zlib_compress(compressor.by, data, bytes, to, room));
    return to;
}
unsigned int checksum(unsigned char const* data, int size)
{
    return libdeflate_crc32(0, data, static_cast<std::size_t>(size));
}
#    define STBIW_ZLIB_COMPRESS deflated
#    define STBIW_CRC32 checksum
#endif
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

std::string shared::png_bytes(tilemesh::report::Image const& image)
{
    auto const rgb = tilemesh::report::rgb8(image);
    std::string png;
    stbi_write_force_png_filter = 4; // Paeth: to try all filters takes half as long again, and saves less than 1 %
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

void shared::write_png(std::filesystem::path const& path, tilemesh::report::Image const& image, tilemesh::report::Outlasts outlasts)
{
    tilemesh::report::write_whole(path, png_bytes(image), {}, outlasts);
}
