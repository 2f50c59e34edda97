// test: without test asan tsan
#include "runner_of.hpp"

using namespace support;

SUPPORT_SHARED(LargestHold);
SUPPORT_SHARED(LargestDrop);
SUPPORT_SHARED(LargestDrop, CheckedMesh);
