#include "runner_of.hpp"

using namespace support;

SUPPORT_SHARED(Whole, CheckedMesh);
SUPPORT_SHARED(tilemesh::splat::Lossless, CheckedMesh);
SUPPORT_SHARED(Screens, CheckedMesh);
