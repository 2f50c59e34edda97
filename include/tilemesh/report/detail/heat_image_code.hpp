#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <tilemesh/report/heat_image.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST HeatRange finite_range(std::span<double const> values) noexcept
{
    HeatRange range;
    bool any = false;
    for (double const v : values) {
        if (!std::isfinite(v)) continue;
        range = any ? HeatRange{std::min(range.least, v), std::max(range.most, v)} : HeatRange{v, v};
        any = true;
    }
    return range;
}

TILEMESH_HOST std::array<float, 3> heat_colour(double share) noexcept
{
    constexpr std::array<std::array<std::uint8_t, 3>, 9> points = {
        {{68, 1, 84}, {71, 45, 123}, {59, 82, 139}, {44, 114, 142}, {33, 145, 140}, {40, 174, 128}, {92, 200, 99}, {170, 220, 50}, {253, 231, 37}}};
    if (std::isnan(share)) return heat_gap;
    double const at = std::clamp(share, 0.0, 1.0) * (points.size() - 1);
    auto const below = std::min(static_cast<std::size_t>(at), points.size() - 2);
    double const part = at - static_cast<double>(below);
    std::array<float, 3> out;
    for (std::size_t c = 0; c < 3; ++c) out[c] = static_cast<float>((points[below][c] + part * (points[below + 1][c] - points[below][c])) / 255);
    return out;
}

TILEMESH_HOST Image heat_image(std::span<double const> values, std::uint32_t width, std::uint32_t height, HeatRange range,
                               std::uint32_t cell_px, std::uint32_t cell_high_px)
{
    if (cell_high_px == 0) cell_high_px = cell_px;
    auto const refuse = [](std::string const& why, char const* remedy) { throw Error("a heat map cannot be drawn (" + why + "); " + remedy); };
    if (values.size() != std::uint64_t{width} * height)
        refuse(std::to_string(values.size()) + " values are not " + std::to_string(width) + " x " + std::to_string(height), "give one a cell");
    if (!std::isfinite(range.least) || !std::isfinite(range.most) || range.least > range.most)
        refuse("its range is not finite or not in order", "give finite_range of the values");
    auto const side = std::max(std::uint64_t{width} * cell_px, std::uint64_t{height} * cell_high_px);
    if (values.empty() || cell_px == 0 || side > 65'535)
        refuse("its picture has " + std::to_string(std::uint64_t{width} * cell_px) + " x " +
                   std::to_string(std::uint64_t{height} * cell_high_px) + " pixels",
               "choose sides of 1 to 65,535");

    Image image(width * cell_px, height * cell_high_px);
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            double const v = values[std::size_t{y} * width + x];
            // Halves first: the difference of two finite doubles may not be finite.
            double const span = range.most / 2 - range.least / 2;
            double const share = span > 0 ? (v / 2 - range.least / 2) / span : v > range.most ? 1.0 : 0.0;
            auto const colour = std::isfinite(v) ? heat_colour(share) : heat_gap;
            for (std::uint32_t i = 0; i < cell_px; ++i) std::copy(colour.begin(), colour.end(), image.pixel(x * cell_px + i, y * cell_high_px));
        }
        auto const* const row = image.pixel(0, y * cell_high_px);
        for (std::uint32_t i = 1; i < cell_high_px; ++i) std::copy_n(row, std::size_t{3} * image.width, image.pixel(0, y * cell_high_px + i));
    }
    return image;
}

TILEMESH_HOST Image heat_legend(std::uint32_t width, std::uint32_t height)
{
    if (width == 0 || height == 0) throw Error("a legend cannot be drawn (it has no pixels); give it a width and a height");
    Image image(width, height);
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x) {
            auto const colour = heat_colour(width == 1 ? 0.0 : static_cast<double>(x) / (width - 1));
            std::copy(colour.begin(), colour.end(), image.pixel(x, y));
        }
    return image;
}

}}} // namespace tilemesh::report
