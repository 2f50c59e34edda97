// A stand-in for the header of the same name in the Poplar SDK. It only stores eight-bit floats; it has no arithmetic on
// them.
#pragma once
#include <cstdint>

struct quarter {
    std::uint8_t bits;
};
