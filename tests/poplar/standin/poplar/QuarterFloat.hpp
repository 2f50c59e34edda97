// A stand-in for the header of the same name in the Poplar SDK: the name alone. Eight-bit floats are stored, not computed
// with.
#pragma once
#include <cstdint>

struct quarter {
    std::uint8_t bits;
};
