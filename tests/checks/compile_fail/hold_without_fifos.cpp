// EXPECT: a setup that holds needs FIFOs
#include "source.hpp"
#include <tilemesh/splat/frame_program.hpp>

struct Setup : tilemesh::splat::Paper { // whose FIFOs have no byte
    using Saturation = tilemesh::splat::Hold;
};

tilemesh::Vote run(Source& source)
{
    return tilemesh::run_kernel<tilemesh::splat::Route<Setup>>(source);
}
