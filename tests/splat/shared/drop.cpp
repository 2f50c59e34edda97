#include "runner_of.hpp"

using namespace support;

SUPPORT_SHARED(Dropping);
SUPPORT_SHARED(tilemesh::splat::Paper);
SUPPORT_SHARED(tilemesh::splat::Prototype);
SUPPORT_SHARED(Room<DropBase>);
