#pragma once
#include <cstdint>
#include <tilemesh/config.hpp>

namespace tilemesh { inline namespace v0_2 {

/// The four sides of a tile. y grows southwards, as the rows of a picture do.
enum class Direction : std::uint32_t { north, east, west, south };

inline constexpr Direction news[4] = {Direction::north, Direction::east, Direction::west, Direction::south};
inline constexpr Direction along_row[2] = {Direction::east, Direction::west};
inline constexpr Direction along_column[2] = {Direction::north, Direction::south};

TILEMESH_KERNEL constexpr std::uint32_t index(Direction d) noexcept
{
    return static_cast<std::uint32_t>(d);
}
TILEMESH_KERNEL constexpr Direction opposite(Direction d) noexcept
{
    return news[3 - index(d)];
}

/// A set of sides: `Sides::east | Sides::south`.
enum class Sides : std::uint32_t { none = 0, north = 1, east = 2, west = 4, south = 8, all = 15 };

TILEMESH_KERNEL constexpr Sides operator|(Sides a, Sides b) noexcept
{
    return static_cast<Sides>(static_cast<std::uint32_t>(a) | static_cast<std::uint32_t>(b));
}
TILEMESH_KERNEL constexpr bool contains(Sides sides, Direction d) noexcept
{
    return (static_cast<std::uint32_t>(sides) >> index(d) & 1u) != 0;
}
/// The sides opposite to those of a set.
TILEMESH_KERNEL constexpr Sides opposite(Sides sides) noexcept
{
    auto const s = static_cast<std::uint32_t>(sides);
    return static_cast<Sides>((s & 1u) << 3 | (s & 2u) << 1 | (s & 4u) >> 1 | (s & 8u) >> 3);
}
/// The number of sides in a set; `before`: of those that come before d in `news`.
TILEMESH_KERNEL constexpr std::uint32_t count(Sides sides) noexcept
{
    auto const s = static_cast<std::uint32_t>(sides);
    return (s & 1u) + (s >> 1 & 1u) + (s >> 2 & 1u) + (s >> 3 & 1u);
}
TILEMESH_KERNEL constexpr std::uint32_t before(Sides sides, Direction d) noexcept
{
    return count(static_cast<Sides>(static_cast<std::uint32_t>(sides) & ((1u << index(d)) - 1u)));
}
/// Side i of a set, in the order of `news`; i < count(sides).
TILEMESH_KERNEL constexpr Direction side_of(Sides sides, std::uint32_t i) noexcept
{
    if (sides == Sides::all) return news[i];
    for (std::uint32_t n = 0; n < 4; ++n)
        if (contains(sides, news[n]) && i-- == 0) return news[n];
    return news[0];
}

/// A tile's column and row in one word, so that a message can carry them. Each is below 65,536.
struct TileId {
    std::uint32_t packed = 0;
    TILEMESH_KERNEL static constexpr TileId at(std::uint32_t x, std::uint32_t y) noexcept { return {x | y << 16}; }
    TILEMESH_KERNEL constexpr std::uint32_t x() const noexcept { return packed & 0xffffu; }
    TILEMESH_KERNEL constexpr std::uint32_t y() const noexcept { return packed >> 16; }
};
TILEMESH_KERNEL constexpr bool operator==(TileId a, TileId b) noexcept
{
    return a.packed == b.packed;
}
#if __cplusplus < 202002L
TILEMESH_KERNEL constexpr bool operator!=(TileId a, TileId b) noexcept
{
    return a.packed != b.packed;
}
#endif

/// The rule for messages (and notes) that a tile sends over an edge of the grid. Every channel names its rule.
enum class Edge : std::uint32_t {
    reflect, ///< they come back to their own tile, on the side where they left
    drop,    ///< they are not sent: they count in no counter and wake no tile. The receiving end on that side stays empty
    wrap     ///< they arrive at the other end of the row or column; with `wrap` on every channel, the grid is a torus
};

/// A range over the tiles of a grid, row by row: `for (TileId tile : grid.tiles())`.
class TileRange;

/// W x H tiles with north, east, west and south neighbours. The paper's is 40 x 36.
struct Grid {
    std::uint32_t width = 40;
    std::uint32_t height = 36;

    TILEMESH_KERNEL constexpr std::uint32_t size() const noexcept { return width * height; }
    TILEMESH_KERNEL constexpr TileId tile(std::uint32_t i) const noexcept { return TileId::at(i % width, i / width); }
    TILEMESH_KERNEL constexpr std::uint32_t index_of(TileId t) const noexcept { return t.y() * width + t.x(); }
    TILEMESH_KERNEL constexpr bool has_neighbour(TileId t, Direction d) const noexcept
    {
        return d == Direction::north   ? t.y() > 0
               : d == Direction::south ? t.y() + 1 < height
               : d == Direction::west  ? t.x() > 0
                                       : t.x() + 1 < width;
    }
    constexpr TileRange tiles() const noexcept;
    /// The tile on side `d`; at an edge the tile itself, because edges reflect.
    TILEMESH_KERNEL constexpr TileId neighbour(TileId t, Direction d) const noexcept
    {
        if (!has_neighbour(t, d)) return t;
        return d == Direction::north   ? TileId::at(t.x(), t.y() - 1)
               : d == Direction::south ? TileId::at(t.x(), t.y() + 1)
               : d == Direction::west  ? TileId::at(t.x() - 1, t.y())
                                       : TileId::at(t.x() + 1, t.y());
    }
    /// The side of `neighbour(t, d)` on which messages from `t` towards `d` arrive. At an edge they come back on side `d`.
    TILEMESH_KERNEL constexpr Direction arrival(TileId t, Direction d) const noexcept
    {
        return has_neighbour(t, d) ? opposite(d) : d;
    }
    /// The tile that receives messages from `t` towards `d` on a channel with these edges. No tile receives them if `delivers` is false.
    TILEMESH_KERNEL constexpr TileId neighbour(TileId t, Direction d, Edge edge) const noexcept
    {
        if (edge != Edge::wrap || has_neighbour(t, d)) return neighbour(t, d);
        return d == Direction::north   ? TileId::at(t.x(), height - 1)
               : d == Direction::south ? TileId::at(t.x(), 0)
               : d == Direction::west  ? TileId::at(width - 1, t.y())
                                       : TileId::at(0, t.y());
    }
    TILEMESH_KERNEL constexpr Direction arrival(TileId t, Direction d, Edge edge) const noexcept
    {
        return edge == Edge::wrap ? opposite(d) : arrival(t, d);
    }
    /// Does anybody receive what `t` sends towards `d` on a channel with these edges?
    TILEMESH_KERNEL constexpr bool delivers(TileId t, Direction d, Edge edge) const noexcept
    {
        return edge != Edge::drop || has_neighbour(t, d);
    }
};

class TileRange {
public:
    class Iterator {
    public:
        using value_type = TileId;
        using difference_type = std::int32_t;
        constexpr Iterator() noexcept = default;
        constexpr Iterator(Grid grid, std::uint32_t i) noexcept : grid_(grid), i_(i) {}
        constexpr TileId operator*() const noexcept { return grid_.tile(i_); }
        constexpr Iterator& operator++() noexcept
        {
            ++i_;
            return *this;
        }
        constexpr Iterator operator++(int) noexcept { return {grid_, i_++}; }
        friend constexpr bool operator==(Iterator const& a, Iterator const& b) noexcept { return a.i_ == b.i_; }
        friend constexpr bool operator!=(Iterator const& a, Iterator const& b) noexcept { return a.i_ != b.i_; }

    private:
        Grid grid_{};
        std::uint32_t i_ = 0;
    };
    constexpr explicit TileRange(Grid grid) noexcept : grid_(grid) {}
    constexpr Iterator begin() const noexcept { return {grid_, 0}; }
    constexpr Iterator end() const noexcept { return {grid_, grid_.size()}; }

private:
    Grid grid_;
};
constexpr TileRange Grid::tiles() const noexcept
{
    return TileRange{*this};
}

}} // namespace tilemesh
