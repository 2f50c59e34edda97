// A stand-in for the header of the same name in the Poplar SDK: the short vectors of ipudef.h.
#pragma once
#include <ipudef.h>
