// A stand-in for the header of the same name in the Poplar SDK. popc's linker reads stack sizes from a section of the object.
// A host has no such section, so nothing checks the stack sizes here.
#pragma once

#define DEF_STACK_USAGE(bytes, symbol)
#define DEF_STACK_SIZE_OWN(bytes, symbol)
#define DEF_FUNC_CALL_PTRS(caller, callees)
