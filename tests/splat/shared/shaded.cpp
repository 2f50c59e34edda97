// test: unoptimised test, without asan tsan
#include "runner_of.hpp"

using namespace support;

SUPPORT_SHARED(tilemesh::splat::Fitted<Whole, 2>);
