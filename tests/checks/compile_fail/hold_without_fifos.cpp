// EXPECT: a setup that holds needs FIFOs
#include <tilemesh/render/setup.hpp>

struct Setup : tilemesh::splat::Paper { // whose FIFOs have no slot
    using Saturation = tilemesh::splat::Hold;
};

tilemesh::render::Setup facts()
{
    return tilemesh::render::setup_for<Setup>();
}
