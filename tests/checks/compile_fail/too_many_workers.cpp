// EXPECT: a machine with more workers than Work counts for
#include "source.hpp"
#include <tilemesh/splat/frame_program.hpp>

struct EightWorkers : tilemesh::Mk2 {
    static constexpr std::uint32_t workers = 8;
};
struct Setup : tilemesh::splat::Lossless {
    using Machine = EightWorkers;
};

tilemesh::Vote run(Source& source)
{
    return tilemesh::run_kernel<tilemesh::splat::Composite<Setup>>(source);
}
