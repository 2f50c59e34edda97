// The file for which CMake makes the precompiled header that the others use.
