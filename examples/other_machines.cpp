// Machines that are no IPU, each in 15 lines: what a frame costs on 132 tiles of 256 KB and on a wafer of 1,000 x 850 tiles, and why a
// pixel processor array cannot be one. Times are modelled; what is assumed about a machine is printed.
//
// usage: other_machines [--whole] [--out DIR]
// --whole: all of the wafer (100 s on two cores and 10.4 GB when it was measured); otherwise 160 x 136 tiles from its middle
// --out DIR: also each machine's cold start in files: a page (.html), its trace by tile and by superstep (.csv), a timeline for
//   ui.perfetto.dev (.trace.json), maps of load, channel fill, busy and idle cycles (.ppm), and the cost model (.model.txt)
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <tilemesh/tilemesh.hpp>
#include <utility>

using namespace tilemesh;

struct Multiprocessors {                                  // a GPU's (NVIDIA H100 SXM), as if they had channels between neighbours
    static constexpr char const* name = "132 multiprocessors";
    static constexpr std::uint32_t tiles = 132;
    static constexpr std::uint32_t sram_bytes = 256 * 1024; // L1 and shared memory
    static constexpr std::uint32_t code_bytes = 0;          // instructions and stacks lie elsewhere
    static constexpr std::uint32_t workers = 4;             // warp schedulers
    static constexpr std::uint32_t clock_khz = 1'700'000;
};
struct Wafer {                                            // a Cerebras WSE-2: 850,000 cores of 48 KB (Lie, IEEE Micro, 2023)
    static constexpr char const* name = "a wafer";
    static constexpr std::uint32_t tiles = 1000 * 850;
    static constexpr std::uint32_t sram_bytes = 48 * 1024;
    static constexpr std::uint32_t code_bytes = 8 * 1024;
    static constexpr std::uint32_t workers = 1;
    static constexpr std::uint32_t clock_khz = 1'100'000;
};
struct PixelProcessors {                                  // a SCAMP: 256 x 256; about 10 bytes a pixel (the paper, table 1)
    static constexpr char const* name = "pixel processors";
    static constexpr std::uint32_t tiles = 256 * 256;
    static constexpr std::uint32_t sram_bytes = 10;
    static constexpr std::uint32_t code_bytes = 0;
    static constexpr std::uint32_t workers = 1;
    static constexpr std::uint32_t clock_khz = 10'000;
};

struct OnMultiprocessors : splat::Lossless {
    static constexpr char const* name = Multiprocessors::name;
    using Machine = Traced<Multiprocessors>;
    static constexpr splat::Sizes sizes{.storage = 1400, .road = 40, .beam = 40, .waiting = 40, .tile_pixels = 54 * 33};
};
struct OnWafer : splat::Lossless {
    static constexpr char const* name = Wafer::name;
    using Machine = Traced<Wafer>;
    static constexpr splat::Sizes sizes{.storage = 211, .road = 8, .beam = 8, .waiting = 8, .tile_pixels = 2 * 2};
};
// The least that a frame can ask for: one record and one pixel a tile, nothing moves, nothing spans two tiles. `BasicRenderer` of it is
// refused by the budget (tests/checks/compile_fail/pixel_processors.cpp), so ask what it takes before.
struct OnPixels : splat::Lossless {
    using Pixel = splat::Rgbx8Pixel;
    static constexpr bool routes = false, blooms = false;
    static constexpr splat::Sizes sizes{.storage = 1, .road = 1, .beam = 1, .waiting = 1, .tile_pixels = 1};
};
constexpr auto least_bytes = bytes_needed<PixelProcessors, splat::Frame<OnPixels>, OnPixels>;
static_assert(!fits<PixelProcessors, splat::Frame<OnPixels>, OnPixels> && fits<Wafer, splat::Frame<OnWafer>, OnWafer>);

/// Writes a page, and the files beside it, about the frame that `renderer` has just rendered.
template <class Shown>
void write_page(std::filesystem::path const& folder, CostModel const& model, Shown& renderer)
{
    using Machine = typename Shown::Setup::Machine;
    auto const& mesh = std::as_const(renderer.mesh());
    TracePage page;
    page.title = "A cold start on " + std::string(Machine::name);
    page.facts = {{"machine", report::thousands(Machine::tiles) + " tiles of " + report::thousands(Machine::sram_bytes) + " bytes"}};
    auto const ledger = Shown::Layout::ledger();
    page.ledger.assign(ledger.begin(), ledger.end());
    TileMap load{"load", "Load", "records that a tile stores, copies among them", true, {}};
    for (std::uint32_t t = 0; t < mesh.grid().size(); ++t)
        load.values.push_back(mesh.template state<splat::Marks<typename Shown::Policies>>(mesh.grid().tile(t)).size());
    page.maps = {load};
    std::string name = Machine::name;
    std::replace(name.begin(), name.end(), ' ', '_');
    write_trace_page(folder, name, renderer.trace(), model, mesh.grid(), page);
}

/// Ledger, model, and what each of three frames costs: a cold start, a step of half a degree, the same view again. True where the
/// pictures have the bits of a loop without tiles, a step costs less than a cold start, and standing still less than that.
template <class S>
bool report_on(scene::Map const& map, CostModel const& model, splat::Camera const& camera, RendererOptions options,
               std::optional<std::filesystem::path> const& out)
{
    using Shown = BasicRenderer<splat::Referenced<S>>;    // the machine of S; the host moves references
    using report::thousands;
    options.threads = 2;
    options.arithmetic = splat::Arithmetic::precise;      // the naive loop's
    Shown renderer{map, options};
    renderer.prepare(camera.width, camera.height);
    auto const grid = renderer.mesh().grid();
    std::cout << "== " << S::Machine::name << ": " << grid.width << " x " << grid.height << " of " << thousands(S::Machine::tiles)
              << " tiles, " << camera.width << " x " << camera.height << " pixels\n"
              << ledger_table(Shown::Layout::ledger(), S::Machine::sram_bytes) << '\n' << assumed_text(model) << '\n';

    auto cameras = scene::orbit(camera, scene::robust_centre(map), 0.5, 2);
    cameras.push_back(cameras.back());
    bool ok = true;
    std::optional<std::uint64_t> before;
    for (auto const& at : cameras) {
        auto const frame = renderer.render(at);
        auto const& r = frame.report;
        auto const cost = model_cost(model, renderer.trace(), grid);
        std::cout << '\n' << cost_table(model, renderer.trace(), cost) << "frame: " << milliseconds_text(model, cost.cycles)
                  << " ms modelled, " << r.supersteps.total() << " exchanges; " << thousands(r.gaussians.moved) << " Gaussians moved, "
                  << thousands(r.copies) << " copies, " << thousands(r.lost_copies) << " lost, " << thousands(r.gaussians.unplaced)
                  << " unplaced, " << thousands(r.peak_storage) << " records on the fullest tile\n";
        auto const naive = report::render_naive(map.gaussians, at, renderer.model()).rgb;
        bool const same = frame.image.rgb.size() == naive.size() &&
                          std::memcmp(frame.image.rgb.data(), naive.data(), naive.size() * sizeof(float)) == 0;
        std::cout << (same ? "The picture has the bits of the naive loop's.\n" : "The picture is NOT the naive loop's.\n");
        ok = ok && same && r.lost.empty() && (!before || cost.cycles < *before);
        if (out && !before) write_page(*out, model, renderer); // the cold start only
        before = cost.cycles;
    }
    std::cout << '\n';
    return ok;
}

int main(int argc, char** argv)
try {
    bool whole = false;
    std::optional<std::filesystem::path> out;
    for (int i = 1; i < argc; ++i) {
        std::string const argument = argv[i];
        if (argument == "--whole") whole = true;
        else if (argument == "--out" && i + 1 < argc && *argv[i + 1] != '\0') out = argv[++i];
        else throw Error("no such argument, or no DIR after it (usage: other_machines [--whole] [--out DIR]); correct " + argument);
    }
    auto const map = scene::built_in_map();
    // The fullest of 132 tiles would hold 3,800 records of the built-in map (measured with more SRAM): it shows a third of them.
    auto third = map;
    for (std::size_t i = 0; 3 * i < map.gaussians.size(); ++i) third.gaussians[i] = map.gaussians[3 * i];
    third.gaussians.resize((map.gaussians.size() + 2) / 3);
    bool ok = report_on<OnMultiprocessors>(third, assumed_model<Multiprocessors>(32, 1000), scene::built_in_camera({640, 360}),
                                           {.grid = {12, 11}, .tile = {54, 33}}, out);
    // Each tile has 2 x 2 pixels of 2,000 x 1,700. A part of the wafer shows its part of the picture.
    auto camera = scene::built_in_camera({2000, 1700});
    Extent2 const part = whole ? Extent2{1000, 850} : Extent2{160, 136};
    camera.cx -= static_cast<float>(1000 - part.width);
    camera.cy -= static_cast<float>(850 - part.height);
    camera.width = 2 * part.width;
    camera.height = 2 * part.height;
    ok = report_on<OnWafer>(map, assumed_model<Wafer>(4, 1850), camera, {.grid = part, .tile = {2, 2}}, out) && ok;

    std::cout << "== " << PixelProcessors::name << ": " << PixelProcessors::sram_bytes
              << " bytes a tile. A frame of one record and one pixel a tile takes " << least_bytes << " (a record is "
              << sizeof(splat::Gaussian) << ", the view " << sizeof(splat::View) << "): it does not compile.\n";
    return ok ? 0 : 1;
} catch (std::bad_alloc const&) {
    std::cerr << "the mesh does not fit into memory (--whole takes 10.4 GB, with --out more); leave --whole out or free memory\n";
    return 2;
} catch (std::exception const& error) { // Error, and what the system refuses
    std::cerr << error.what() << '\n';
    return 2;
}
