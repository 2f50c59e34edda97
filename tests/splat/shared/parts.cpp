// test: unoptimised test, without tsan
#include "runner_of.hpp"

using namespace support;

SUPPORT_SHARED(NoRouting);
SUPPORT_SHARED(NoBloom);
SUPPORT_SHARED(Minimal);
