#pragma once
#include <string>
#include <tilemesh/engine/rectangle.hpp>
#include <tilemesh/error.hpp>

namespace tilemesh { inline namespace v0_2 { namespace engine {

TILEMESH_HOST Rectangle checked_rectangle(Grid grid, Rectangle r)
{
    if (r.x0 > r.x1 || r.y0 > r.y1 || r.x1 > grid.width || r.y1 > grid.height)
        throw Error("columns " + std::to_string(r.x0) + " to " + std::to_string(r.x1) + " and rows " + std::to_string(r.y0) +
                    " to " + std::to_string(r.y1) + " (the grid has " + std::to_string(grid.width) + " x " +
                    std::to_string(grid.height) + " tiles); choose a rectangle inside it");
    return r;
}

}}} // namespace tilemesh::engine
