// EXPECT: the program does not fit in a tile's SRAM
// EXPECT: SramBudget<.*TestMachine<1024.*, Pile, 1012U?, 20U?>
#include <tilemesh/engine/mesh_sizes.hpp>

// 1,024 bytes: 8 words of cell, and a pile of 251 words and its head. The setup's slots are a constant: nobody has to run it.
struct Slots {
    std::uint32_t pile = 0;
};
struct Cell {
    float part[8];
};
struct Pile : tilemesh::Buffer<float> {
    static constexpr auto slots = &Slots::pile;
};
struct Step {
    void operator()(Cell&, Pile& pile) const noexcept { pile.truncate(0); }
};
using Program = tilemesh::Superstep<Step>;
template <std::uint32_t N>
struct Setup {
    static constexpr Slots sizes{N};
};

auto full() { return tilemesh::mesh_sizes<Program, tilemesh::TestMachine<1024>, Setup<246>>(); } // fits exactly
auto over() { return tilemesh::mesh_sizes<Program, tilemesh::TestMachine<1024>, Setup<251>>(); }
