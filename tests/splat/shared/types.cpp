// test: unoptimised test
// The renderers by reference whose types say planes and steps, as a program without the compiled library has them.
#include "runner_of.hpp"

using namespace support;

SUPPORT_SHARED(Referenced<Whole>, tilemesh::Mesh);
SUPPORT_SHARED(Referenced<Planes>, tilemesh::Mesh);
SUPPORT_SHARED(Referenced<DropScreens>, tilemesh::Mesh);
SUPPORT_SHARED(Referenced<NoRouting>, tilemesh::Mesh);
SUPPORT_SHARED(Referenced<NoBloom>, tilemesh::Mesh);
SUPPORT_SHARED(Referenced<Minimal>, tilemesh::Mesh);
