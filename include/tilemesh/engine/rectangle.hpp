#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>
#include <tilemesh/machine/grid.hpp>

namespace tilemesh { inline namespace v0_2 { namespace engine {

/// Columns x0 to x1 - 1 and rows y0 to y1 - 1 of a grid.
struct Rectangle {
    std::uint32_t x0, y0, x1, y1;
    bool contains(TileId t) const noexcept { return t.x() >= x0 && t.x() < x1 && t.y() >= y0 && t.y() < y1; }
    bool covers(Grid grid) const noexcept { return x0 == 0 && y0 == 0 && x1 == grid.width && y1 == grid.height; }
};
/// Returns the rectangle. Throws `Error` if it is not inside the grid.
TILEMESH_HOST Rectangle checked_rectangle(Grid grid, Rectangle r);

}}} // namespace tilemesh::engine

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/engine/detail/rectangle_code.hpp>
#endif
