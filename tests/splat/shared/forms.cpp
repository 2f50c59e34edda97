// test: without test asan tsan
#include "runner_of.hpp"

using namespace support;

SUPPORT_SHARED(Shaded);
SUPPORT_SHARED(DropScreens);
SUPPORT_SHARED(ShadedScreens);
