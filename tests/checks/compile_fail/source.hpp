#pragma once
#include <tilemesh/machine/tile.hpp>

// What an interpreter offers a kernel; never run.
struct Source {
    template <class X>
    tilemesh::machine::Place state();
    template <class C>
    tilemesh::machine::Place in(tilemesh::Direction);
    template <class C>
    tilemesh::machine::Place out(tilemesh::Direction);
    template <class P>
    P const* shared();
    tilemesh::Here here();
    tilemesh::Worker worker();
};
