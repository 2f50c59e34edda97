#include "runner_of.hpp"

using namespace support;

SUPPORT_SHARED(Referenced<Whole>);
SUPPORT_SHARED(Referenced<Screens>);
SUPPORT_SHARED(Referenced<Dropping>);
SUPPORT_SHARED(Referenced<Room<DropBase>>);
SUPPORT_SHARED(Referenced<LargestHold>);
SUPPORT_SHARED(Referenced<LargestDrop>);
SUPPORT_SHARED(Referenced<Shaded>);
SUPPORT_SHARED(Referenced<tilemesh::splat::Fitted<Whole, 2>>);
SUPPORT_SHARED(Referenced<tilemesh::splat::Fitted<Screens, 2>>);
SUPPORT_SHARED(Referenced<tilemesh::splat::Lossless>);
SUPPORT_SHARED(Referenced<tilemesh::splat::Paper>);
SUPPORT_SHARED(Referenced<FixedSizes>);
