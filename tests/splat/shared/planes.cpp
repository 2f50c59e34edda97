// test: unoptimised test, without tsan
#include "runner_of.hpp"

using namespace support;

SUPPORT_SHARED(Planes);
SUPPORT_SHARED(BytesAndPlanes);
