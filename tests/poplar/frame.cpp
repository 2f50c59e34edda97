// test: unoptimised asan, without tsan, needs data, cost 25
#include "../compare_reports.hpp"
#include "../splat/scenes.hpp"
#include "on_poplar.hpp"
#include <array>
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/scene/orbit.hpp>
#include <tilemesh/splat/bounded.hpp>

// The frame program as codelets on a graph, on the stand-in for Poplar: it gives the pictures, counters and words of the thread engine.
namespace {
using namespace tilemesh;
using poplar_test::executions;

/// Renders the cameras on both. Every bit and every count must agree, and after the last frame every word of every tile.
template <class S>
void compare(scene::Map const& map, std::string const& prefix, RendererOptions const& options, std::vector<splat::Camera> const& cameras)
{
    BasicRenderer<S> threads{map, options};
    BasicRenderer<S, PoplarMesh> graph{map, options, poplar_test::options(prefix)};
    RenderedFrame expected, frame;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        CAPTURE(i);
        threads.render_into(cameras[i], expected);
        graph.render_into(cameras[i], frame);
        CHECK(support::differing_pixels(frame.image, expected.image) == 0);
        CHECK(report::first_difference(frame.report, expected.report) == "");
        if constexpr (is_traced<typename S::Machine>) CHECK(graph.mesh().trace() == threads.mesh().trace());
    }
    CHECK(expected.report.pairs > 0);
    poplar_test::check_same_words(threads.mesh(), graph.mesh());
}

/// A view, and three steps of 0.5 degrees around its centre.
std::vector<splat::Camera> walk(scene::Map const& map, splat::Camera const& from)
{
    return scene::orbit(from, scene::robust_centre(map), 0.5, 4);
}

/// Sloth at 1280 x 720 from the paper authors' view, or the map that stands in, on 1,440 tiles.
template <class S>
void whole_frame(std::string const& prefix)
{
    standin::Restore const restore;
    poplar_test::use(executions[2]);
    standin::settings().check_inputs = false; // the check digests all inputs of 1,440 tiles in each superstep
    if constexpr (S::sizes.lists_fit) {
        std::size_t left = 0; // bytes that the ledger leaves for code, exchange code and stacks; the rest must fit in 624 KiB
        for (auto const& line : on_poplar::ledger<Mk2, splat::Frame<S>, S>(Grid{40, 36})) left = line.bytes;
        standin::settings().code_bytes = left;
    } else {
        standin::settings().tile_bytes = 1u << 20; // our lists do not fit in the paper's budget, as the ledger shows
    }
    if (support::fast()) { // sanitizers run the same program on fewer tiles
        RendererOptions options;
        options.tile = {16, 20};
        auto const map = support::map_of(support::cloud(400, 3));
        std::vector<splat::Camera> cameras;
        for (float turn : {0.0f, 0.01f, 0.02f}) cameras.push_back(support::lens(112, 100, turn));
        compare<S>(map, prefix, options, cameras);
        return;
    }
    auto const& scene = support::scenes<640>()[0];
    auto const* camera = &scene.cameras[0].second;
    for (auto const& [name, c] : scene.cameras)
        if (name == "benchmark") camera = &c;
    RendererOptions options;
    options.threads = 2;
    compare<S>(scene.map, prefix, options, walk(scene.map, *camera));
}

} // namespace

// Small machines: other numbers of workers, channels of few slots, copies in screen form, bounded hops, a trace.
template <std::uint32_t N>
struct Workers : TestMachine<64u << 20> {
    static constexpr std::uint32_t workers = N;
};
struct Held : support::Small<7, 400> {
    using Machine = Traced<Workers<6>>;
    static constexpr splat::Arithmetic arithmetic = splat::Arithmetic::fast;
};
struct Dropped : support::Small<5, 60, splat::Paper> {
    using Machine = Workers<4>;
    using Copies = splat::ScreenCopies;
};
struct Bounding : splat::Bounded {
    using Machine = Workers<5>;
};
#define FRAME(Name, S)                                                                                                         \
    VERTEX(Name##_project, S::Machine, splat::Frame<S>, splat::Project<S>)                                                     \
    VERTEX(Name##_route, S::Machine, splat::Frame<S>, splat::Route<S>)                                                         \
    VERTEX(Name##_bloom, S::Machine, splat::Frame<S>, splat::Bloom<S>)                                                         \
    VERTEX(Name##_depth_sort, S::Machine, splat::Frame<S>, splat::DepthSort<S>)                                                \
    MULTI_VERTEX(Name##_composite, S::Machine, splat::Frame<S>, splat::Composite<S>)
FRAME(held, Held)
FRAME(dropped, Dropped)
FRAME(bounding, Bounding)

TEST_CASE("poplar: Sloth, lossless with float pixels, a cold start and three steps of an orbit")
{
    whole_frame<splat::Lossless>("lossless");
}

TEST_CASE("poplar: Sloth, paper with RGBX8 pixels, a cold start and three steps of an orbit")
{
    whole_frame<splat::Paper>("paper");
}

TEST_CASE("poplar: a static view moves no records between host and machine, and a lookup none back")
{
    RendererOptions options;
    options.tile = {16, 20};
    BasicRenderer<splat::Lossless, PoplarMesh> graph{support::map_of(support::cloud(150, 4)), options, poplar_test::options("lossless")};
    auto const camera = support::lens(112, 100);
    auto const copies = [&] {
        auto const before = standin::host_copies(graph.mesh().engine());
        graph.render(camera);
        return standin::host_copies(graph.mesh().engine()) - before;
    };
    graph.render(camera);
    // In: the tiles that run, and the camera. Out: the log of tiles, the log of the run, counters, pair counters, framebuffers.
    CHECK(copies() == 2 + 5);
    // Words that the host accessed for writing are copied to the device once.
    graph.mesh().state<splat::Counts>(TileId::at(0, 0)).visible += 0;
    CHECK(copies() == 2 + 5 + 1);
}

TEST_CASE("poplar: order and number of workers change nothing, with equal traces; starved channels, drop, bounded hops")
{
    standin::Restore const restore;
    standin::settings().tile_bytes = 64u << 20;
    auto const map = support::map_of(support::cloud(support::fast() ? 150 : 500, 11));
    std::vector<splat::Camera> cameras;
    for (float turn : {0.0f, 0.02f, 0.3f, 0.3f}) cameras.push_back(support::lens(150, 70, turn)); // the last frame is static
    RendererOptions options;
    options.tile = {20, 16};
    for (auto const& e : executions) {
        CAPTURE(e.name);
        poplar_test::use(e);
        compare<Held>(map, "held", options, cameras);
        compare<Dropped>(map, "dropped", options, cameras);
    }
    options.hops = 1;
    compare<Held>(map, "held", options, cameras);
    options.hops = 0;
    // Other sizes than those of the codelets' setup: codelets serve any sizes.
    auto sizes = Held::sizes;
    sizes.storage = 230;
    sizes.road = 3;
    sizes.beam = 9;
    sizes.waiting = 2;
    options.sizes = sizes;
    compare<Held>(map, "held", options, cameras);
    options.sizes.reset();
    // The rules of training on a background, floats and 8-bit pixels.
    options.quality = splat::Quality::training;
    options.background = std::array<float, 3>{0.75f, 0.25f, 0.5f};
    compare<Held>(map, "held", options, cameras);
    compare<Dropped>(map, "dropped", options, cameras);
    options.quality.reset();
    options.background.reset();
    // Limits below the slots of the layout.
    options.channel_slots = 2;
    options.storage_slots = 200;
    options.waiting_slots = 3;
    compare<Held>(map, "held", options, cameras);
}

TEST_CASE("poplar: a frame that bounds its picture has the picture and the bounds of threads")
{
    standin::Restore const restore;
    standin::settings().tile_bytes = 64u << 20;
    auto const map = support::map_of(support::cloud(support::fast() ? 150 : 500, 11));
    RendererOptions options;
    options.tile = {20, 16};
    for (auto const& e : {executions[0], executions[2], executions[3]}) {
        CAPTURE(e.name);
        poplar_test::use(e);
        compare<Bounding>(map, "bounding", options, {support::lens(150, 70), support::lens(150, 70, 0.02f)});
    }
}

TEST_CASE("poplar: the graph's variables are the ledger of a frame, byte for byte; the paper's lists do not fit beside its budget")
{
    standin::Restore const restore;
    Grid const grid{6, 5};
    poplar_test::check_ledger<splat::Frame<splat::Lossless>, Mk2, splat::Lossless>("lossless", grid);
    // The paper's data have 520,020 bytes, and our lists 243,224 bytes more. Poplar would refuse this, as the ledger says.
    using Paper = splat::Frame<splat::Paper>;
    standin::settings().code_bytes = Mk2::code_bytes;
    PoplarMesh<Paper> mesh{{}, grid, mesh_sizes<Paper, Mk2, splat::Paper>(), poplar_test::options("paper")};
    CHECK(engine_test::has(engine_test::error_of([&] { mesh.prepare(); }), "more than its 638976"));
    standin::settings().tile_bytes = 1u << 20;
    poplar_test::check_ledger<Paper, Mk2, splat::Paper>("paper", grid);
}

TEST_CASE("poplar: the exchange moves whole ends to the four neighbours, and nothing else")
{
    Grid const grid{5, 4};
    using Lossless = splat::Lossless;
    PoplarMesh<splat::Frame<Lossless>> mesh{{}, grid, mesh_sizes<splat::Frame<Lossless>, Mk2, Lossless>(), poplar_test::options("lossless")};
    mesh.prepare();
    std::size_t whole = 0, broadcasts = 0;
    for (auto const& [kind, name, words] : standin::exchanges(mesh.engine())) {
        CAPTURE(name);
        if (kind != standin::Exchange::Kind::copy) { // votes before compute sets: one word per tile, and one word per row
            CHECK(kind == standin::Exchange::Kind::gather);
            CHECK(name.find("votes") == 0);
            for (auto const& move : words) CHECK(move.second == 1);
        } else if (words.size() == grid.size() - 1) { // a broadcast from tile 0 to all other tiles
            ++broadcasts;
            for (auto const& move : words) CHECK(move.first.first == 0);
        } else { // every tile sends one end on each side; at an edge of the grid the end comes back
            ++whole;
            std::map<std::pair<unsigned, unsigned>, std::size_t> expected;
            bool const road = name.find("road") != std::string::npos;
            auto const end = road ? splat::Road<Lossless>::Receiver::words(200) : splat::Beam<Lossless>::Receiver::words(200);
            for (std::uint32_t i = 0; i < grid.size(); ++i)
                for (Direction d : news) expected[{i, grid.index_of(grid.neighbour(grid.tile(i), d))}] += end;
            CHECK(words == expected);
        }
    }
    CHECK(broadcasts == 2);
    CHECK(whole == 3); // routing, the bloom's first superstep, the bloom
}
