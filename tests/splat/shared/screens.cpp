#include "runner_of.hpp"

using namespace support;

SUPPORT_SHARED(Screens);
