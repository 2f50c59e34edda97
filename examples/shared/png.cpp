#include "png.hpp"
#include <cstddef>
#include <cstdlib>
#include <new>
#include <string>
#include <tilemesh/report/image_file.hpp>
#include <tilemesh/report/whole_file.hpp>
#ifdef TILEMESH_HAS_ZLIB
#    include <zlib.h>
#endif

namespace {
/// realloc for stb. Out of memory, stb itself would end the process or write through the null pointer. This function loses the encoder's
/// memory, and the program ends with one line.
void* reallocate(void* old, std::size_t bytes)
{
    if (auto* const memory = std::realloc(old, bytes)) return memory;
    throw std::bad_alloc();
}
#ifdef TILEMESH_HAS_ZLIB
/// Deflates for stb. Of zlib's strategies, this one is for filtered pictures: it looks for runs only. Its files are a tenth smaller than those
/// of zlib's fastest level, in 0.9 of the time, which is a fourth of the time of stb's own encoder.
unsigned char* deflated(unsigned char* data, int size, int* deflated_size, int)
{
    z_stream stream{};
    if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, 15, 8, Z_RLE) != Z_OK) throw std::bad_alloc(); // 15 and 8: zlib's defaults
    struct End {
        z_stream& of;
        ~End() { deflateEnd(&of); }
    } const end{stream};
    uLong const room = deflateBound(&stream, static_cast<uLong>(size));
    auto* const to = static_cast<unsigned char*>(reallocate(nullptr, room));
    stream.next_in = data;
    stream.avail_in = static_cast<uInt>(size);
    stream.next_out = to;
    stream.avail_out = static_cast<uInt>(room);
    if (deflate(&stream, Z_FINISH) != Z_STREAM_END) {
        std::free(to);
        throw std::bad_alloc(); // there is room, so memory was short
    }
    *deflated_size = static_cast<int>(stream.total_out);
    return to;
}
#    define STBIW_ZLIB_COMPRESS deflated
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
