#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>

namespace tilemesh { inline namespace v0_2 { namespace engine {

/// Columns x0 to x1 - 1 and rows y0 to y1 - 1 of a grid.
struct Rectangle {
    std::uint32_t x0, y0, x1, y1;
    bool contains(TileId t) const noexcept { return t.x() >= x0 && t.x() < x1 && t.y() >= y0 && t.y() < y1; }
    bool covers(Grid grid) const noexcept { return x0 == 0 && y0 == 0 && x1 == grid.width && y1 == grid.height; }
};
/// Returns the rectangle. Throws `Error` if it is not inside the grid.
inline Rectangle checked_rectangle(Grid grid, Rectangle r)
{
    if (r.x0 > r.x1 || r.y0 > r.y1 || r.x1 > grid.width || r.y1 > grid.height)
        throw Error("columns " + std::to_string(r.x0) + " to " + std::to_string(r.x1) + " and rows " + std::to_string(r.y0) +
                    " to " + std::to_string(r.y1) + " (the grid has " + std::to_string(grid.width) + " x " +
                    std::to_string(grid.height) + " tiles); choose a rectangle inside it");
    return r;
}

}}} // namespace tilemesh::engine
