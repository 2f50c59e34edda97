// The heat equation on the mesh: one cell a tile, insulated walls. Kernel code: compiled for host threads and as a codelet.
#pragma once
#include <tilemesh/machine/kernel.hpp>

using namespace tilemesh;

struct Cell { float kelvin; };                      // what a tile keeps
struct Conductivity { float per_step; };            // what every tile is told
struct Wall : Channel<float, 1> {};                 // what a tile tells its neighbours

struct Diffuse {
    void operator()(Cell& cell, Broadcast<Conductivity> k, In<Wall> in, Out<Wall> out) const noexcept
    {
        float flow = 0;
        for (auto d : news)
            for (float neighbour : in[d]) flow += neighbour - cell.kelvin;
        cell.kelvin += k->per_step * flow;
        for (auto d : news) out[d].unchecked_push(cell.kelvin); // at an edge this comes back: no heat is lost
    }
};
using Heat = Sequence<Repeat<Diffuse>>;             // Heat{{{1000}}}: how often is a value
