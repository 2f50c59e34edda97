// test: without tsan
#include "runner_of.hpp"

using namespace support;

SUPPORT_SHARED(Referenced<NoRouting>);
SUPPORT_SHARED(Referenced<NoBloom>);
SUPPORT_SHARED(Referenced<Minimal>);
