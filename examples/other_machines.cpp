// Machines that are no IPU, each in 15 lines: what a frame costs on 132 tiles of 256 KB and on a wafer of 1,000 x 850 tiles, and why a
// pixel processor array cannot be one. Times are modelled; what is assumed about a machine is printed.
//
// usage: other_machines [--whole]
// --whole: all of the wafer (100 s on two cores and 10.4 GB when it was measured); otherwise 160 x 136 tiles from its middle
#include <chrono>
#include <cstdint>
#include <cstring>
#include <iostream>
#include <string>
#include <sys/resource.h>
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

template <class M, std::uint32_t Channel, std::uint32_t Stored, std::uint32_t Pixels>
struct On : splat::Lossless {                             // slots of a channel end, slots of storage, pixels
    static constexpr char const* name = M::name;
    using Machine = Traced<M>;
    static constexpr std::uint32_t storage_slots = Stored;
    static constexpr std::uint32_t road_bytes = Channel * sizeof(splat::Addressed);
    static constexpr std::uint32_t beam_bytes = Channel * sizeof(splat::Gaussian);
    static constexpr std::uint32_t waiting_bytes = Channel * sizeof(splat::Addressed);
    static constexpr std::uint32_t tile_pixels = Pixels;
};
using OnMultiprocessors = On<Multiprocessors, 40, 1400, 54 * 33>;
using OnWafer = On<Wafer, 8, 211, 2 * 2>;

// The least that a frame can ask for: one record and one pixel a tile, nothing moves, nothing spans two tiles. `BasicRenderer` of it is
// refused by the budget (tests/checks/compile_fail/pixel_processors.cpp), so ask what it takes before.
struct OnPixels : On<PixelProcessors, 1, 1, 1> {
    using Pixel = splat::Rgbx8Pixel;
    static constexpr bool routes = false, blooms = false;
};
constexpr auto least_bytes = bytes_needed<PixelProcessors, splat::Frame<OnPixels>>;
static_assert(!fits<PixelProcessors, splat::Frame<OnPixels>> && fits<Wafer, splat::Frame<OnWafer>>);

/// mk2()'s numbers where nothing better is known. Its one worker at work issues in every sixth cycle, because six take turns.
template <class M>
CostModel assumed(std::uint64_t bytes_a_cycle, std::uint64_t barrier_cycles)
{
    auto model = mk2();
    model.name = M::name;
    set_parameter(model, "clock", M::clock_khz, "assumed");
    for (Operation o : {Operation::slot, Operation::projection, Operation::routed, Operation::copied, Operation::comparison})
        set_parameter(model, name_of(o), model.millicycles[index(o)] * M::workers / Mk2::workers,
                      "assumed: mk2's instructions, of which a worker issues one in " + std::to_string(M::workers) + " cycles");
    set_parameter(model, "exchange_byte", 1000 / bytes_a_cycle, "assumed: bytes that a tile receives in a cycle");
    set_parameter(model, "sync", barrier_cycles, "assumed");
    set_parameter(model, "vote", 2 * barrier_cycles, "assumed: there and back");
    return model;
}

/// Ledger, model, and what each of three frames costs: a cold start, a step of half a degree, the same view again. True where the
/// pictures have the bits of a loop without tiles, a step costs less than a cold start, and standing still less than that.
template <class S>
bool report_on(scene::Map const& map, CostModel const& model, splat::Camera const& camera, RendererOptions options)
{
    using Shown = BasicRenderer<splat::Referenced<S>>;    // the machine of S; the host moves references
    using report::thousands;
    auto const begin = std::chrono::steady_clock::now();
    options.threads = 2;
    options.arithmetic = splat::Arithmetic::precise;      // the naive loop's
    Shown renderer{map, options};
    renderer.model().arithmetic = splat::Arithmetic::precise;
    renderer.prepare(camera.width, camera.height);
    auto const grid = renderer.mesh().grid();
    std::cout << "== " << S::Machine::name << ": " << grid.width << " x " << grid.height << " of " << thousands(S::Machine::tiles)
              << " tiles, " << camera.width << " x " << camera.height << " pixels\n";
    report::Table ledger{{"region", "bytes of a tile"}};
    for (Region const& r : Shown::Layout::ledger()) ledger.add_row({std::string(r.name.text, r.name.size), thousands(r.bytes)});
    std::cout << ledger.add_row({"sum, of " + thousands(S::Machine::sram_bytes), thousands(Shown::Layout::bytes)}) << '\n';
    char const* text = "assumed: ";
    for (auto const& p : model.parameters)
        if (p.source.rfind("assumed", 0) == 0)
            std::cout << std::exchange(text, ", ") << p.name << ' ' << thousands(p.value) << ' ' << p.unit;
    std::cout << '\n';

    auto cameras = scene::orbit(camera, scene::robust_centre(map), 0.5, 2);
    cameras.push_back(cameras.back());
    bool ok = true;
    std::uint64_t before = ~std::uint64_t{0};
    for (auto const& at : cameras) {
        auto const frame = renderer.render(at);
        auto const& r = frame.report;
        auto const& trace = renderer.trace();
        auto const cost = model_cost(model, trace, grid);
        std::cout << '\n' << cost_table(model, trace, cost) << "frame: " << milliseconds_text(model, cost.cycles) << " ms modelled, "
                  << r.supersteps.total() << " exchanges; " << thousands(r.gaussians.moved) << " Gaussians moved, " << thousands(r.copies)
                  << " copies, " << thousands(r.lost_copies) << " lost, " << thousands(r.gaussians.unplaced) << " unplaced, "
                  << thousands(r.peak_storage) << " records on the fullest tile\n";
        auto const naive = report::render_naive(map.gaussians, at, renderer.model());
        bool const same = frame.image.rgb.size() == naive.rgb.size() &&
                          std::memcmp(frame.image.rgb.data(), naive.rgb.data(), naive.rgb.size() * sizeof(float)) == 0;
        std::cout << (same ? "The picture has the bits of the naive loop's.\n" : "The picture is NOT the naive loop's.\n");
        ok = ok && same && r.lost.empty() && cost.cycles < before;
        before = cost.cycles;
    }
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    auto const seconds = std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - begin);
    std::cout << "host, with the naive loop's pictures: " << seconds.count() << " s, " << used.ru_maxrss / 1024 << " MiB at most\n\n";
    return ok;
}

int main(int argc, char** argv)
try {
    bool const whole = argc == 2 && std::string(argv[1]) == "--whole";
    if (argc > 1 && !whole) throw Error("unknown argument (usage: other_machines [--whole]); leave it out");
    auto const map = scene::built_in_map();
    // The fullest of 132 tiles would hold 3,800 records of the built-in map (measured with more SRAM): it shows a third of them.
    auto third = map;
    for (std::size_t i = 0; 3 * i < map.gaussians.size(); ++i) third.gaussians[i] = map.gaussians[3 * i];
    third.gaussians.resize((map.gaussians.size() + 2) / 3);
    bool ok = report_on<OnMultiprocessors>(third, assumed<Multiprocessors>(32, 1000), scene::built_in_camera({640, 360}),
                                           {.grid = {12, 11}, .tile = {54, 33}});
    // Each tile has 2 x 2 pixels of 2,000 x 1,700. A part of the wafer shows its part of the picture.
    auto camera = scene::built_in_camera({2000, 1700});
    Extent2 const part = whole ? Extent2{1000, 850} : Extent2{160, 136};
    camera.cx -= static_cast<float>(1000 - part.width);
    camera.cy -= static_cast<float>(850 - part.height);
    camera.width = 2 * part.width;
    camera.height = 2 * part.height;
    ok = report_on<OnWafer>(map, assumed<Wafer>(4, 1850), camera, {.grid = part, .tile = {2, 2}}) && ok;

    std::cout << "== " << PixelProcessors::name << ": " << PixelProcessors::sram_bytes
              << " bytes a tile. A frame of one record and one pixel a tile takes " << least_bytes << " (a record is "
              << sizeof(splat::Gaussian) << ", the view " << sizeof(splat::View) << "): it does not compile.\n";
    return ok ? 0 : 1;
} catch (Error const& error) {
    std::cerr << error.what() << '\n';
    return 2;
}
