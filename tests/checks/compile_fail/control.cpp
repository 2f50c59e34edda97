// COMPILES
#include <tilemesh/machine/tile.hpp>

// What the others are near misses of.
struct Cell {
    float heat;
};
struct Wire : tilemesh::Channel<Cell, 4> {};
struct Pile : tilemesh::Buffer<Cell, 8> {};
struct Rate {
    float rate;
};
struct Exchange {
    tilemesh::Vote operator()(Cell& cell, Pile& pile, tilemesh::In<Wire> in, tilemesh::Out<Wire> out,
                              tilemesh::Broadcast<Rate> p, tilemesh::Here) const noexcept
    {
        cell.heat *= p->rate;
        for (tilemesh::Direction d : tilemesh::news)
            if (!in[d].empty() && out[d].try_push(cell)) pile.truncate(0);
        return tilemesh::Vote::quiet;
    }
};
struct Work {
    void operator()(Cell const&, Pile&, tilemesh::Worker) const noexcept {}
};
using Program = tilemesh::Sequence<tilemesh::Superstep<Exchange>, tilemesh::Repeat<Exchange>,
                                   tilemesh::UntilQuiet<Exchange>, tilemesh::Superstep<Work>>;

static_assert(tilemesh::Tile<tilemesh::Mk2, Program>::bytes > 0);
