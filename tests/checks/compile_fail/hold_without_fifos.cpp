// EXPECT: a setup that holds needs FIFOs
#include <tilemesh/render/setup_choice.hpp>

struct Setup : tilemesh::splat::Paper { // whose FIFOs have no slot
    using Saturation = tilemesh::splat::Hold;
};

tilemesh::render::SetupFacts facts()
{
    return tilemesh::render::facts_of<Setup>();
}
