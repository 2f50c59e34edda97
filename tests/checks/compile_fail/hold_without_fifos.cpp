// EXPECT: a setup that holds needs FIFOs
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/splat/frame_program.hpp>

struct Setup : tilemesh::splat::Paper { // whose FIFOs have no byte
    using Saturation = tilemesh::splat::Hold;
};
struct Source {
    template <class X>
    tilemesh::Place state();
    template <class C>
    tilemesh::Place in(tilemesh::Direction);
    template <class C>
    tilemesh::Place out(tilemesh::Direction);
    template <class P>
    P const* shared();
    tilemesh::Here here();
    tilemesh::Worker worker();
};

tilemesh::Vote run(Source& source)
{
    return tilemesh::run_kernel<tilemesh::splat::Route<Setup>>(source);
}
