#pragma once
#include "../standard.hpp"
#include <tilemesh/machine/kernel.hpp>
#include <tilemesh/machine/spec.hpp>

/// Small programs whose results the tests know from another source.
namespace engine_test {
using namespace tilemesh;

/// A machine with 64 MiB per tile and any number of tiles.
using Bench = TestMachine<64u << 20>;

// --- heat ------------------------------------------------------------------------------------
struct Cell {
    float kelvin;
};
struct Conductivity {
    float per_step;
};
struct Wall : Channel<float, 1> {};
struct Diffuse {
    void operator()(Cell& cell, Broadcast<Conductivity> k, In<Wall> in, Out<Wall> out) const noexcept
    {
        float flow = 0;
        for (auto d : news)
            for (float neighbour : in[d]) flow += neighbour - cell.kelvin;
        cell.kelvin += k->per_step * flow;
        for (auto d : news) out[d].unchecked_push(cell.kelvin);
    }
};
using Heat = Sequence<Repeat<Diffuse>>;

// --- life: 8 x 8 cells per tile; rows are sent sideways first, so that corners arrive through the row neighbours --------------
struct Patch {
    std::uint32_t row[8]; ///< bit x is cell x
};
struct Widened {
    std::uint32_t row[10]; ///< bit x + 1 is cell x; rows 0 and 9 are rows of the neighbours
};
struct Strip : Channel<std::uint32_t, 10> {};
struct TellSideways {
    void operator()(Patch const& patch, Out<Strip> out) const noexcept
    {
        for (Direction d : along_row)
            for (auto row : patch.row) out[d].push(row);
    }
};
struct TellUpAndDown {
    void operator()(Patch const& patch, Widened& wide, Here here, In<Strip> in, Out<Strip> out) const noexcept
    {
        bool const has_west = here.grid.has_neighbour(here.tile, Direction::west);
        bool const has_east = here.grid.has_neighbour(here.tile, Direction::east);
        wide = {};
        for (std::uint32_t y = 0; y < 8; ++y) { // cells outside the grid are dead
            wide.row[y + 1] = patch.row[y] << 1;
            if (has_west) wide.row[y + 1] |= in[Direction::west][y] >> 7 & 1u;
            if (has_east) wide.row[y + 1] |= (in[Direction::east][y] & 1u) << 9;
        }
        out[Direction::north].push(wide.row[1]);
        out[Direction::south].push(wide.row[8]);
    }
};
struct Live {
    void operator()(Patch& patch, Widened& wide, Here here, In<Strip> in) const noexcept
    {
        if (here.grid.has_neighbour(here.tile, Direction::north)) wide.row[0] = in[Direction::north][0];
        if (here.grid.has_neighbour(here.tile, Direction::south)) wide.row[9] = in[Direction::south][0];
        for (std::uint32_t y = 0; y < 8; ++y) {
            patch.row[y] = 0;
            for (std::uint32_t x = 0; x < 8; ++x) {
                std::uint32_t neighbours = 0;
                for (std::uint32_t j = 0; j < 3; ++j)
                    for (std::uint32_t i = 0; i < 3; ++i) neighbours += i == 1 && j == 1 ? 0u : wide.row[y + j] >> (x + i) & 1u;
                bool const alive = (wide.row[y + 1] >> (x + 1) & 1u) != 0;
                patch.row[y] |= (neighbours == 3 || (alive && neighbours == 2) ? 1u : 0u) << x;
            }
        }
    }
};
using Generation = Sequence<Superstep<TellSideways>, Superstep<TellUpAndDown>, Superstep<Live>>;

// --- bounce: one token in a row of tiles; at an edge the token returns to the tile that sent it --------------------------------
struct Ball {
    std::uint32_t throws; ///< number of throws that are left
};
struct Visits {
    std::uint32_t count;
};
struct Lane : Channel<std::uint32_t, 1> {};
struct Throw {
    void operator()(Ball& ball, Out<Lane> out) const noexcept
    {
        if (ball.throws != 0) out[Direction::east].push(ball.throws - 1);
        ball.throws = 0;
    }
};
struct Catch {
    void operator()(Visits& visits, In<Lane> in, Out<Lane> out) const noexcept
    {
        for (Direction from : along_row)
            for (auto throws : in[from]) {
                ++visits.count;
                if (throws != 0) out[opposite(from)].push(throws - 1);
            }
    }
};
using Bounce = Sequence<Superstep<Throw>, UntilQuiet<Catch>>;

// --- post: parcels to any tiles, along the row first; the channels never fill ---------------------------------------------------
struct Parcel {
    std::uint32_t id;
    TileId to;
    float contents[2];
};
struct Outbox : Buffer<Parcel, 32> {};
struct Inbox : Buffer<Parcel, 1024> {};
struct Road : Channel<Parcel, 4096> {};

constexpr Direction towards(TileId from, TileId to) noexcept
{
    return to.x() > from.x() ? Direction::east : to.x() < from.x() ? Direction::west : to.y() > from.y() ? Direction::south : Direction::north;
}
constexpr std::uint32_t distance(TileId a, TileId b) noexcept
{
    return (a.x() > b.x() ? a.x() - b.x() : b.x() - a.x()) + (a.y() > b.y() ? a.y() - b.y() : b.y() - a.y());
}
struct Depart {
    void operator()(Outbox& outbox, Inbox& inbox, Here here, Out<Road> out) const noexcept
    {
        for (Parcel const& p : outbox)
            if (p.to == here.tile) inbox.push(p);
            else out[towards(here.tile, p.to)].push(p);
        outbox.truncate(0);
    }
};
struct Deliver {
    void operator()(Inbox& inbox, Here here, In<Road> in, Out<Road> out) const noexcept
    {
        for (Direction from : news)
            for (Parcel const& p : in[from])
                if (p.to == here.tile) inbox.push(p);
                else out[towards(here.tile, p.to)].push(p);
    }
};
using Post = Sequence<Superstep<Depart>, UntilQuiet<Deliver>>;

// --- sorting: odd-even transposition along each row, one key per tile ------------------------------------------------------------
struct Key {
    std::uint32_t value;
    std::uint32_t phase;
};
struct Offer : Channel<std::uint32_t, 1> {};
struct Trade {
    void operator()(Key& key, Here here, In<Offer> in, Out<Offer> out) const noexcept
    {
        // The partner of the previous phase has offered its key. The western tile keeps the smaller key.
        for (auto offered : in[Direction::east]) key.value = std::min(key.value, offered);
        for (auto offered : in[Direction::west]) key.value = std::max(key.value, offered);
        Direction const partner = (here.tile.x() + key.phase) % 2 == 0 ? Direction::east : Direction::west;
        if (here.grid.has_neighbour(here.tile, partner)) out[partner].push(key.value);
        ++key.phase;
    }
};
struct Settle { // reads the last offers
    void operator()(Key& key, In<Offer> in) const noexcept
    {
        for (auto offered : in[Direction::east]) key.value = std::min(key.value, offered);
        for (auto offered : in[Direction::west]) key.value = std::max(key.value, offered);
        key.phase = 0;
    }
};
using SortRows = Sequence<Repeat<Trade>, Superstep<Settle>>; ///< `times` of Repeat is the length of a row

} // namespace engine_test
