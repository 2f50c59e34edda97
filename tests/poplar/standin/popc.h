// Part of the stand-in for the Poplar SDK: the declarations that popc has before the first line of a codelet. Host builds of
// public codelets include it with `-include popc.h`. Without it, an unqualified sqrt or floor is the function for double, and
// std::swap, memcpy and others, which popc's headers declare, may be undeclared.
#pragma once
#include <algorithm>
#include <limits>
#include <math.h>
#include <stdint.h>
#include <string.h>
#include <utility>

#ifndef __POPC__
#define __POPC__ 1
#endif
