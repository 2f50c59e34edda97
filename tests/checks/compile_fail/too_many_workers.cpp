// EXPECT: a machine with more workers than Work counts for
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/splat/frame_program.hpp>

struct EightWorkers : tilemesh::Mk2 {
    static constexpr std::uint32_t workers = 8;
};
struct Setup : tilemesh::splat::Lossless {
    using Machine = EightWorkers;
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
    return tilemesh::run_kernel<tilemesh::splat::Composite<Setup>>(source);
}
