// EXPECT: no machine .it has the members name, tiles, sram_bytes, code_bytes, workers and clock_khz, as Mk2 has.; look for a misspelt one
#include <tilemesh/machine/tile.hpp>

struct Cell {
    float heat;
};
struct Step {
    void operator()(Cell& cell) const noexcept { cell.heat = 0; }
};
struct Mine {
    static constexpr char const* name = "mine";
    static constexpr std::uint32_t tiles = 256, worker = 4, clock_khz = 500'000, sram_bytes = 32 * 1024, code_bytes = 8 * 1024;
};

constexpr auto bytes = tilemesh::bytes_needed<Mine, tilemesh::Superstep<Step>>;
