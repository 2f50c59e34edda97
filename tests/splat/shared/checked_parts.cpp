// test: without test asan tsan
#include "runner_of.hpp"

using namespace support;

SUPPORT_SHARED(NoRouting, CheckedMesh);
SUPPORT_SHARED(Planes, CheckedMesh);
