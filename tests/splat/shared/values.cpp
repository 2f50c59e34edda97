#include "runner_of.hpp"

using namespace support;

SUPPORT_SHARED(Whole);
SUPPORT_SHARED(tilemesh::splat::Lossless);
SUPPORT_SHARED(FixedSizes);
