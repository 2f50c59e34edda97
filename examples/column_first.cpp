// Your own routing rule: along the column first, then along the row. The picture stays the same; the traffic differs.
#include <iostream>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/splat/setup_types.hpp>

namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;
using tilemesh::Direction, tilemesh::TileId;

struct ColumnFirst {
    static constexpr char const* name = "column_first";
    static constexpr Direction first_leg[2] = {Direction::north, Direction::south};
    static constexpr Direction towards(TileId from, TileId to) noexcept
    {
        if (to.y() != from.y()) return to.y() > from.y() ? Direction::south : Direction::north;
        return to.x() > from.x() ? Direction::east : Direction::west;
    }
};
struct Mine : splat::Lossless {
    static constexpr char const* name = "lossless, column first";
    using Routing = ColumnFirst;
};

int main()
{
    auto const map = scene::built_in_map();
    auto const camera = scene::built_in_camera({640, 360});
    auto const rows = tilemesh::Renderer{map}.render(camera);
    auto const columns = tilemesh::BasicRenderer<splat::Referenced<Mine>>{map}.render(camera);
    bool const same = rows.image.rgb == columns.image.rgb;
    std::cout << "row first:    " << rows.report.hops << " hops, " << rows.report.exchanges.route << " exchanges, at most "
              << rows.report.peak_channel << " records in a channel\n"
              << "column first: " << columns.report.hops << " hops, " << columns.report.exchanges.route
              << " exchanges, at most " << columns.report.peak_channel << " records in a channel\n"
              << (same ? "the pictures are equal in every bit\n" : "the pictures differ\n");
    return same ? 0 : 1;
}
