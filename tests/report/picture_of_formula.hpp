#pragma once
#include <cstdint>
#include <tilemesh/report/image.hpp>

/// A picture of 8-bit levels by a formula, so that another program can make it too.
inline tilemesh::report::Image picture_of_formula(std::uint32_t width, std::uint32_t height)
{
    tilemesh::report::Image image{width, height};
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x)
            for (std::uint32_t c = 0; c < 3; ++c)
                image.pixel(x, y)[c] = static_cast<float>((x * x * 31 + y * y * 17 + x * y * 7 + c * 91 + 13 * x) % 256) / 255.0f;
    return image;
}
