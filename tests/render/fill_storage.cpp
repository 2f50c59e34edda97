// test: unoptimised test asan tsan
// Storage takes the rest of the SRAM, in both programs.
#include "../standard.hpp"
#include <tilemesh/render/homes_layout.hpp>
#include <tilemesh/render/renderer_options.hpp>
#include <tilemesh/render/setup.hpp>
#include <tilemesh/splat/setup_types.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;

TEST_CASE("fill_storage: storage takes the rest of the SRAM, that many slots fit and one more does not")
{
    Grid const grid{40, 36};
    for (Extent2 const tile : {Extent2{1, 1}, Extent2{32, 20}, Extent2{48, 30}})
        for (std::uint32_t const degree : {0u, 3u})
            for (std::uint32_t const sram : {560'000u, 638'976u, 64u << 20}) {
                auto anchored = render::fitted(splat::setup_of<Lossless>(), degree, true, true);
                anchored.machine.sram_bytes = sram;
                auto filled = render::fill_storage(anchored, grid, tile);
                CHECK(filled.sizes.tile_pixels == tile.width * tile.height);
                CHECK(filled.sizes.road == anchored.sizes.road);
                CHECK(render::checked(filled).sizes.storage == filled.sizes.storage);
                ++filled.sizes.storage;
                CHECK_THROWS_AS(render::checked(filled), Error);

                auto homes = splat::homes_setup;
                homes.sh_degree = degree, homes.machine.sram_bytes = sram;
                if (sram > 560'000u) homes.fit = true;
                auto full = render::fill_storage(homes, grid, tile);
                RendererOptions options;
                options.grid = {grid.width, grid.height};
                Extent2 const frame{grid.width * tile.width, grid.height * tile.height};
                auto const layout = render::layout_homes(full, options, frame, 1);
                CHECK(layout.setup.sizes.homes == full.sizes.homes);
                CHECK(layout.setup.sizes.storage == homes.sizes.storage);
                ++full.sizes.homes;
                CHECK_THROWS_AS(render::layout_homes(full, options, frame, 1), Error);
            }
    auto const setup = render::fill_storage(splat::lossless, Grid{40, 36}, {32, 20});
    CHECK(setup.sizes.storage == 2012);
}

TEST_CASE("fill_storage refuses a grid, a tile and an SRAM without room")
{
    auto const anchored = splat::setup_of<Lossless>(), homes = splat::homes_setup;
    CHECK_THROWS_WITH_AS(render::fill_storage(anchored, Grid{40, 37}, {32, 20}), "a grid of 40 x 37 tiles (mk2 has 1472); choose 1 to all of them",
                         Error);
    CHECK_THROWS_AS(render::fill_storage(homes, Grid{40, 37}, {32, 20}), Error);
    CHECK_THROWS_AS(render::fill_storage(anchored, Grid{0, 36}, {32, 20}), Error);
    for (auto const& setup : {anchored, homes}) // the pixels alone are too many
        for (Extent2 const tile : {Extent2{65535, 65537}, Extent2{65535, 20}, Extent2{1000, 1000}, Extent2{0, 20}})
            CHECK_THROWS_AS(render::fill_storage(setup, Grid{40, 36}, tile), Error);
}

TEST_CASE("on_machine: a preset keeps its sizes where they fit; elsewhere channels shrink as the SRAM does, and storage takes the rest")
{
    auto const lossless = splat::setup_of<Lossless>();
    auto machine = size_of_machine<Mk2>();
    CHECK(render::on_machine(lossless, machine, 640).sizes == lossless.sizes);
    machine.sram_bytes *= 2;
    CHECK(render::on_machine(lossless, machine, 640).sizes == lossless.sizes);

    // Half of the bytes behind the code: half of the slots of channels and FIFOs.
    machine = size_of_machine<Mk2>();
    machine.sram_bytes = machine.code_bytes + (machine.sram_bytes - machine.code_bytes) / 2;
    auto half = render::on_machine(lossless, machine, 320);
    CHECK(half.machine.sram_bytes == machine.sram_bytes);
    CHECK(half.sizes.road == 100);
    CHECK(half.sizes.beam == 100);
    CHECK(half.sizes.waiting == 100);
    CHECK(half.sizes.tile_pixels == 320);
    CHECK(render::checked(half).sizes.storage > 1000);
    ++half.sizes.storage;
    CHECK_THROWS_AS(render::checked(half), Error);
    CHECK(render::on_machine(lossless, machine, 320, 30).sizes.road == 30);
    CHECK(render::on_machine(lossless, machine, 320, 30).sizes.storage > half.sizes.storage);
    CHECK(render::on_machine(lossless, machine, 320, 5000).sizes.road == 200); // at most the preset's

    // More pixels than the preset has: storage gives way.
    auto const large = render::on_machine(lossless, size_of_machine<Mk2>(), 4000);
    CHECK(large.sizes.tile_pixels == 4000);
    CHECK(large.sizes.road == lossless.sizes.road);
    CHECK(large.sizes.storage < lossless.sizes.storage - 250);
    CHECK(render::sram_bytes_of(render::checked(large)) <= large.machine.sram_bytes);

    machine.sram_bytes = machine.code_bytes + 100; // no room for a slot: check_setup says so
    CHECK(render::on_machine(lossless, machine, 1).sizes.storage == 1);
    CHECK_THROWS_AS(render::checked(render::on_machine(lossless, machine, 1)), Error);

    auto homes = splat::homes_setup;
    auto const small = render::on_machine(homes, half.machine, 0);
    CHECK(small.sizes.road == 60);
    CHECK(small.sizes.waiting == 60);
    CHECK(render::on_machine(homes, half.machine, 0, 7).sizes.road == 7);
    CHECK(render::on_machine(homes, size_of_machine<Mk2>(), 0).sizes == homes.sizes);
}

TEST_CASE("keeps_sizes: homes fit with a home for each record and all held splats, or they do not")
{
    // The homes that show 36,000 records at 640 x 360 on 40 x 36 tiles take 441,544 bytes (25 homes a tile).
    auto homes = splat::homes_setup;
    homes.fit = true;
    homes.machine.sram_bytes = 441'544;
    RendererOptions options;
    options.grid = {40, 36};
    options.held_slots = 5000; // a limit of a frame changes nothing
    Extent2 const frame{640, 360};
    CHECK(render::keeps_sizes(homes, options, frame, 36'000));
    CHECK_FALSE(render::keeps_sizes(homes, options, frame, 36'001)); // one home more
    CHECK_FALSE(render::keeps_sizes(homes, options, frame, 3'000'000)); // comes in chapters
    --homes.machine.sram_bytes;
    CHECK_FALSE(render::keeps_sizes(homes, options, frame, 36'000));
    homes.machine.sram_bytes = 1000; // nothing fits
    CHECK_FALSE(render::keeps_sizes(homes, options, frame, 1));
}
