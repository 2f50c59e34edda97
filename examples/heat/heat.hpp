// The heat equation, one cell a tile. Kernel code: it runs on host threads and as a codelet of an IPU.
#pragma once
#include <tilemesh/machine/kernel.hpp>
struct Cell { float kelvin; };                      // what a tile keeps
struct Conductivity { float per_step; };            // what the host tells every tile
struct Wall : tilemesh::Channel<float, 1> {};       // what a tile sends to each neighbour
struct Diffuse {
    void operator()(Cell& cell, tilemesh::Broadcast<Conductivity> k, tilemesh::In<Wall> in, tilemesh::Out<Wall> out) const noexcept
    {
        float flow = 0;
        for (auto side : tilemesh::news)
            for (float neighbour : in[side]) flow += neighbour - cell.kelvin;
        cell.kelvin += k->per_step * flow;
        out.to_all(cell.kelvin);                    // at an edge it comes back: no heat is lost
    }
};
