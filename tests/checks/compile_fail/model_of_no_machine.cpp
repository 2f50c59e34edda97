// EXPECT: no machine .it has the members name, tiles, sram_bytes, code_bytes, workers and clock_khz, as Mk2 has.; look for a misspelt one
#include <tilemesh/model/assumed_parameters.hpp>

struct Mine {
    static constexpr char const* names = "mine";
    static constexpr std::uint32_t tiles = 256, workers = 4, clock_khz = 500'000, sram_bytes = 32 * 1024, code_bytes = 8 * 1024;
};

auto model() { return tilemesh::assumed_model<Mine>(4, 100); }
