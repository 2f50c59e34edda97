#include "runner_of.hpp"

using namespace support;

SUPPORT_SHARED(Screens);
SUPPORT_SHARED(ShadedScreens);
