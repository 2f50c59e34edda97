// A stand-in for the header of the same name in popc: printf from a codelet.
#pragma once
#include <stdio.h>
