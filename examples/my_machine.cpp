// Your own machine, its ledger, and the value of a channel slot on it: the exchanges and refusals of a cold start.
#include <cstdint>
#include <iostream>
#include <string>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/splat/setup_types.hpp>
#include <tilemesh/splat/setup.hpp>

namespace report = tilemesh::report;
namespace scene = tilemesh::scene;
namespace splat = tilemesh::splat;

struct Camera256 {                                        // many small tiles, as behind a sensor
    static constexpr char const* name = "camera256";
    static constexpr std::uint32_t tiles = 4096;
    static constexpr std::uint32_t sram_bytes = 256 * 1024;
    static constexpr std::uint32_t code_bytes = 40 * 1024;
    static constexpr std::uint32_t workers = 4;
    static constexpr std::uint32_t clock_khz = 800'000;
};
struct Small : splat::Lossless {
    static constexpr char const* name = "small";
    using Machine = Camera256;                            // the hardware: a type
    using Pixel = splat::Rgbx8Pixel;                      // policies: types that change what kernels do
    static constexpr splat::Sizes sizes{                  // slots: a value; sizes that exceed the SRAM do not compile
        .storage = 700, .road = 100, .beam = 100, .waiting = 100, .tile_pixels = 16 * 12};
};

int main()
{
    using MyRenderer = tilemesh::BasicRenderer<splat::Referenced<Small>>; // by reference: the host stores each record once
    using Layout = MyRenderer::Layout;
    for (auto const& r : Layout::ledger())
        std::cout << std::string(r.name.text, r.name.size) << ": " << r.bytes << " bytes\n";
    std::cout << "sum: " << Layout::bytes << " of " << Camera256::sram_bytes << "\n\n";

    auto const map = scene::built_in_map();
    auto const camera = scene::built_in_camera({960, 540});
    report::Table table{{"slots a channel", "exchanges", "refusals", "unplaced", "copies lost", "fullest tile"}};
    std::uint64_t refused_before = 0;
    bool grows = true;
    for (std::uint32_t slots : {100u, 50u, 20u, 10u, 5u}) {
        auto sizes = Small::sizes;
        sizes.road = sizes.beam = slots;                  // another value, but the same renderer
        auto const frame = MyRenderer{map, {.tile = {16, 12}, .sizes = sizes}}.render(camera);
        auto const& r = frame.report;
        using report::thousands;
        table.add_row({std::to_string(slots), std::to_string(r.exchanges.total()), thousands(r.gaussians.held),
                       thousands(r.gaussians.unplaced), thousands(r.lost_copies), thousands(r.peak_storage)});
        grows = grows && r.gaussians.held > refused_before;
        refused_before = r.gaussians.held;
    }
    std::cout << table;
    return grows ? 0 : 1; // check: fewer slots give more refusals
}
