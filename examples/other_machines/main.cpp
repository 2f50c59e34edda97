// The cost of a frame on two machines that are not IPUs: 132 tiles of 256 KB, and a wafer of 1,000 x 850 tiles. Times are modelled, and the
// program prints its assumptions. tests/checks/compile_fail/pixel_processors.cpp shows why a pixel processor array cannot run a frame.
//
// usage: other_machines [--whole] [--out DIR]
// --whole: all of the wafer (100 s on two cores and 10.4 GB when it was measured); otherwise 160 x 136 tiles from its middle
// --out DIR: also each machine's cold start in files: a page (.html), its trace by tile and by superstep (.csv), a timeline for
//   ui.perfetto.dev (.trace.json), the numbers of its maps (.maps.csv), and the cost model (.model.txt)
#include "machines.hpp"
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <string>
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/model/assumed_parameters.hpp>
#include <tilemesh/model/bottleneck.hpp>
#include <tilemesh/model/confidence.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_table.hpp>
#include <tilemesh/model/trace_maps.hpp>
#include <tilemesh/model/trace_page.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/naive.hpp>
#include <tilemesh/report/number_text.hpp>
#include <tilemesh/report/table.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <utility>

namespace report = tilemesh::report;
namespace splat = tilemesh::splat;

namespace {

/// Prints the ledger of a setup, the assumptions about its machine, and the cost of three frames: a cold start, a step of 0.5 degrees, and
/// the same view again. If a folder `out` is given, it also writes a page about the cold start. Returns true if three conditions hold:
/// every picture equals in every bit that of a loop without tiles, the step costs less than the cold start, and the same view less than the
/// step.
bool report_on(splat::Setup const& setup, tilemesh::scene::Map const& map, tilemesh::CostModel const& model, splat::Camera const& camera,
               tilemesh::RendererOptions options, std::filesystem::path const& out)
{
    std::string const machine = setup.machine.name;
    options.threads = 2;
    options.arithmetic = splat::Arithmetic::precise;      // the arithmetic of the naive loop
    options.trace = true;
    tilemesh::Renderer renderer{map, setup, options};
    renderer.prepare(camera.width, camera.height);
    tilemesh::Grid const grid{renderer.grid().width, renderer.grid().height};
    auto const ledger = tilemesh::render::ledger_of(setup);
    std::cout << "== " << machine << ": " << grid.width << " x " << grid.height << " of " << report::thousands(setup.machine.tiles)
              << " tiles, " << camera.width << " x " << camera.height << " pixels\n"
              << tilemesh::ledger_table(ledger, setup.machine.sram_bytes) << '\n' << tilemesh::assumed_text(model) << '\n';
    auto cameras = tilemesh::scene::orbit(camera, tilemesh::scene::robust_centre(map), 0.5, 2);
    cameras.push_back(cameras.back());
    bool ok = true;
    std::uint64_t before = 0;
    for (auto const& at : cameras) {
        auto const frame = renderer.render(at);
        auto const cost = tilemesh::model_cost(model, renderer.trace(), grid);
        auto const naive = report::render_naive(map.gaussians, at, renderer.rules()).rgb;
        bool const same = frame.image.rgb.size() == naive.size() &&
                          std::memcmp(frame.image.rgb.data(), naive.data(), naive.size() * sizeof(float)) == 0;
        std::cout << '\n' << tilemesh::cost_table(model, renderer.trace(), cost) << "frame: " << tilemesh::milliseconds_text(model, cost.cycles)
                  << " ms modelled, assumed\n" << tilemesh::confidence_text(model, renderer.trace(), cost) << '\n'
                  << frame.report << "\nThe picture " << (same ? "has" : "has NOT") << " the bits of the naive loop's.\n";
        ok = ok && same && frame.report.lost.empty() && (before == 0 || cost.cycles < before);
        if (before == 0 && !out.empty()) {
            tilemesh::TileMap load{"load", "Load", "records that a tile stores, copies among them", true, {}, "records"};
            using Core = tilemesh::render::HostRenderer;
            auto const& mesh = std::as_const(dynamic_cast<Core&>(renderer.core()).mesh());
            for (std::uint32_t t = 0; t < grid.size(); ++t) load.values.push_back(mesh.state<splat::Marks<Core::Policies>>(grid.tile(t)).size());
            auto file = machine;
            std::replace(file.begin(), file.end(), ' ', '_');
            tilemesh::TracePage page;
            page.title = "A cold start on " + machine + ", by assumed numbers";
            page.facts = {{"numbers", tilemesh::assumed_text(model)}};
            page.ledger.assign(ledger.begin(), ledger.end());
            page.sram_bytes = setup.machine.sram_bytes;
            page.maps = {load};
            page.run = "frame";
            page.because = [&](tilemesh::Bottleneck const& b) { return "it stores " + report::short_number(load.values[b.tile]) + " records"; };
            page.picture = &frame.image;
            page.tile_px = {options.tile.width, options.tile.height};
            tilemesh::write_trace_page(out, file, renderer.trace(), model, grid, page);
        }
        before = cost.cycles;
    }
    std::cout << '\n';
    return ok;
}

} // namespace

int main(int argc, char** argv)
try {
    bool whole = false;
    std::filesystem::path out;
    for (int i = 1; i < argc; ++i) {
        std::string const argument = argv[i];
        if (argument == "--whole") whole = true;
        else if (argument == "--out" && i + 1 < argc && *argv[i + 1] != '\0') out = argv[++i];
        else throw tilemesh::Error("no such argument, or no DIR after it (usage: other_machines [--whole] [--out DIR]); correct " + argument);
    }
    auto const map = tilemesh::scene::built_in_map();
    // With the whole built-in map, the fullest of 132 tiles would hold 3,800 records (measured with more SRAM): show a third of the map.
    auto third = map;
    for (std::size_t i = 0; 3 * i < map.gaussians.size(); ++i) third.gaussians[i] = map.gaussians[3 * i];
    third.gaussians.resize((map.gaussians.size() + 2) / 3);
    bool ok = report_on(tilemesh::render::setup_for<OnMultiprocessors>(), third, tilemesh::assumed_model<Multiprocessors>(32, 1000),
                        tilemesh::scene::built_in_camera({640, 360}), {.grid = {12, 11}, .tile = {54, 33}}, out);
    // Each tile has 2 x 2 pixels of 2,000 x 1,700. A part of the wafer shows its part of the picture.
    auto camera = tilemesh::scene::built_in_camera({2000, 1700});
    tilemesh::Extent2 const part = whole ? tilemesh::Extent2{1000, 850} : tilemesh::Extent2{160, 136};
    camera.cx -= static_cast<float>(1000 - part.width);
    camera.cy -= static_cast<float>(850 - part.height);
    camera.width = 2 * part.width;
    camera.height = 2 * part.height;
    auto const wafer = tilemesh::render::setup_for<OnWafer>();
    ok = report_on(wafer, map, tilemesh::assumed_model<Wafer>(4, 1850), camera, {.grid = part, .tile = {2, 2}}, out) && ok;
    return ok ? 0 : 1;
} catch (std::bad_alloc const&) {
    std::cerr << "the mesh does not fit into memory (--whole takes 10.4 GB, with --out more); leave --whole out or free memory\n";
    return 2;
} catch (std::exception const& error) { // Error, and what the system refuses
    std::cerr << error.what() << '\n';
    return 2;
}
