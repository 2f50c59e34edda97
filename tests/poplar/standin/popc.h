// Part of the stand-in for the Poplar SDK: what popc has before the first line of a codelet. Host builds of public codelets
// name it with `-include popc.h`; without it an unqualified sqrt or floor is the one for double, and std::swap, memcpy and
// the like may be undeclared, which popc's own headers bring with others.
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
