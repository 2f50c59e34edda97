#pragma once
#include <cstddef>
#include <cstdint>
#include <tilemesh/config.hpp>
#include <tilemesh/report/detail/large_memory.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace report {

/// A linear RGB picture on a black background: row by row from the top left, three floats a pixel, not clamped.
struct Image {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<float> rgb; ///< 3 * width * height

    Image() = default;
    Image(std::uint32_t w, std::uint32_t h) : width(w), height(h) { detail::resize_large(rgb, std::size_t{3} * w * h); }
    float* pixel(std::uint32_t x, std::uint32_t y) noexcept { return &rgb[3 * (std::size_t{y} * width + x)]; }
    float const* pixel(std::uint32_t x, std::uint32_t y) const noexcept { return &rgb[3 * (std::size_t{y} * width + x)]; }
};

/// One float a pixel, row by row from the top left: a depth map, or the share of each pixel that is covered. It is empty unless the setup
/// asks for it.
struct Plane {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<float> values; ///< width * height

    Plane() = default;
    Plane(std::uint32_t w, std::uint32_t h) : width(w), height(h) { detail::resize_large(values, std::size_t{w} * h); }
    bool empty() const noexcept { return values.empty(); }
    float& at(std::uint32_t x, std::uint32_t y) noexcept { return values[std::size_t{y} * width + x]; }
    float at(std::uint32_t x, std::uint32_t y) const noexcept { return values[std::size_t{y} * width + x]; }
};

}}} // namespace tilemesh::report
