#pragma once
#include <tilemesh/splat/harmonics.hpp>

namespace tilemesh { inline namespace v0_2 { namespace splat {

/// Does a splat's rectangle touch tile t? It only compares; it does not divide.
inline bool covers(Splat const& s, Tiling const& tiling, TileId t) noexcept
{
    if (!s.visible()) return false;
    auto const r = s.rect();
    auto const x0 = t.x() * tiling.tile_width, y0 = t.y() * tiling.tile_height;
    return r.x0 < x0 + tiling.tile_width && r.x1 > x0 && r.y0 < y0 + tiling.tile_height && r.y1 > y0;
}

/// The tiles that a splat's rectangle touches, from `first` to `last`, both inclusive.
struct TileBox {
    TileId first, last;
    constexpr std::uint32_t columns() const noexcept { return last.x() - first.x() + 1; }
    constexpr std::uint32_t rows() const noexcept { return last.y() - first.y() + 1; }
    constexpr std::uint32_t count() const noexcept { return columns() * rows(); }
};
/// Requires a visible splat.
inline TileBox tiles_of(Splat const& s, Tiling const& tiling) noexcept
{
    auto const r = s.rect();
    return {TileId::at(r.x0 / tiling.tile_width, r.y0 / tiling.tile_height),
            TileId::at((r.x1 - 1) / tiling.tile_width, (r.y1 - 1) / tiling.tile_height)};
}

/// Is the neighbour on side `d` a child of tile `t` in the bloom tree that is rooted at `anchor`? The tree (the paper, section
/// "Tree-Pattern Bloom") goes from the anchor along its row in both directions, and from every tile of that row along its column in both
/// directions.
///
/// In a rectangle around the anchor, every tile except the anchor has exactly one parent, and the parent lies in the rectangle. So the tree
/// has no cycle, no tile gets a copy twice, and k tiles need k - 1 messages (tests/splat/footprint.cpp proves it at compile time).
constexpr bool is_child(TileId anchor, TileId t, Direction d) noexcept
{
    switch (d) {
    case Direction::east:
        return t.y() == anchor.y() && t.x() >= anchor.x();
    case Direction::west:
        return t.y() == anchor.y() && t.x() <= anchor.x();
    case Direction::south:
        return t.y() >= anchor.y();
    default:
        return t.y() <= anchor.y();
    }
}

}}} // namespace tilemesh::splat
