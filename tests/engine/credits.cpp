// test: unoptimised test asan tsan
// The credit example of the guide: no list is ever full, on any engine and for any length of the row.
#include "everywhere.hpp"

#define main main_of_credits
#include "../../examples/credits.cpp"
#undef main

using namespace engine_test;

struct Tiny : tilemesh::Mk2 { // workers and clock are those of Mk2
    static constexpr char const* name = "tiny";
    static constexpr std::uint32_t tiles = 64, sram_bytes = 8 * 1024, code_bytes = 4 * 1024;
};

TEST_CASE("a machine in three lines runs and refuses what it has not")
{
    tilemesh::Mesh mesh{Row{}, tilemesh::Grid{8, 8}, tilemesh::Traced<Tiny>{}};
    mesh.run();
    CHECK(mesh.machine().sram_bytes == 8 * 1024);
    CHECK(mesh.sram_bytes() == 4 * 1024 + sizeof(Flow) + (8 + 4 * line_slots) + 8 * (8 + 4 * line_slots));
    using TinyMesh = Mesh<Row, Tiny>;
    CHECK_THROWS_WITH_AS((TinyMesh{Row{}, Grid{9, 8}}),
                         "a grid of 9 x 8 = 72 tiles (tiny has 64); choose a smaller grid, larger tiles or another machine", Error);
}

TEST_CASE("credits keep the receiver's list from filling, and lose no word")
{
    for (std::uint32_t const width : {1u, 2u, 5u, 12u})
        for (std::uint32_t const words : {0u, 1u, 4u, 5u, 100u}) {
            CAPTURE(width);
            CAPTURE(words);
            auto const p = everywhere<Row>(Grid{width, 2}, [&](auto& mesh) {
                for (std::uint32_t y = 0; y < 2; ++y) mesh.template state<Flow>(TileId::at(0, y)).left = words + y;
            });
            for (std::uint32_t y = 0; y < 2; ++y) {
                auto const n = words + y;
                CHECK(p.mesh->state<Flow>(TileId::at(width - 1, y)).sum == n * (n + 1) / 2);
            }
            CHECK(p.last().peaks[0].items <= line_slots);
            CHECK(p.last().messages() == (width - 1) * (2 * words + 1));
        }
}
