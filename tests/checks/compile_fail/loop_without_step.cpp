// EXPECT: a Loop without a step .*give it one
#include <tilemesh/machine/tile.hpp>

using Program = tilemesh::Loop<tilemesh::Sequence<>>;

static_assert(tilemesh::StepTraits<Program>::loops == 1);
