// test: without tsan
#include "runner_of.hpp"

using namespace support;

SUPPORT_SHARED(Referenced<Planes>);
SUPPORT_SHARED(Referenced<DropScreens>);
SUPPORT_SHARED(Referenced<BytesAndPlanes>);
SUPPORT_SHARED(Referenced<ShadedScreens>);
SUPPORT_SHARED(Referenced<tilemesh::splat::WithPixel<Whole, tilemesh::splat::WithDepth<tilemesh::splat::FloatPixel>>>);
SUPPORT_SHARED(Referenced<tilemesh::splat::WithPixel<Whole, tilemesh::splat::WithAlpha<tilemesh::splat::FloatPixel>>>);
