// test: unoptimised asan, without tsan, needs data, cost 25
#include "../compare_reports.hpp"
#include "../splat/scenes.hpp"
#include "on_poplar.hpp"
#include <array>
#include <standin_vertex.hpp>
#include <tilemesh/poplar/ledger.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/scene/orbit.hpp>

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
    standin::With const restore(standin::settings());
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

// Small machines: other numbers of workers, channels of few slots, copies in screen form, bounded hops.
template <std::uint32_t N>
struct Workers : TestMachine<64u << 20> {
    static constexpr std::uint32_t workers = N;
};
template <std::uint32_t N>
struct Held : support::Small<7, 400> {
    using Machine = Workers<N>;
    static constexpr splat::Arithmetic arithmetic = splat::Arithmetic::fast;
};
struct Dropped : support::Small<5, 60, splat::Paper> {
    using Machine = Workers<4>;
    using Copies = splat::ScreenCopies;
};
struct Watched : Held<6> {
    using Machine = Traced<Workers<6>>;
};
#define FRAME(Name, S)                                                                                                         \
    TILEMESH_VERTEX(Name##_project, S::Machine, splat::Frame<S>, splat::Project<S>)                                            \
    TILEMESH_VERTEX(Name##_route, S::Machine, splat::Frame<S>, splat::Route<S>)                                                \
    TILEMESH_VERTEX(Name##_bloom, S::Machine, splat::Frame<S>, splat::Bloom<S>)                                                \
    TILEMESH_VERTEX(Name##_depth_sort, S::Machine, splat::Frame<S>, splat::DepthSort<S>)                                       \
    TILEMESH_MULTI_VERTEX(Name##_composite, S::Machine, splat::Frame<S>, splat::Composite<S>)                                  \
    ENTER(Name##_project);                                                                                                     \
    ENTER(Name##_route);                                                                                                       \
    ENTER(Name##_bloom);                                                                                                       \
    ENTER(Name##_depth_sort);                                                                                                  \
    ENTER(Name##_composite)
#define ENTER(Name) POPLAR_STANDIN_VERTEX(Name, reads, keeps, sends, x, y, width, height, step, log_at, task, program)
FRAME(held1, Held<1>);
FRAME(held6, Held<6>);
FRAME(dropped4, Dropped);
FRAME(watched, Watched);

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
    standin::With const restore(standin::settings());
    standin::settings().tile_bytes = 64u << 20;
    RendererOptions options;
    options.tile = {20, 16};
    BasicRenderer<Held<6>, PoplarMesh> graph{support::map_of(support::cloud(150, 4)), options, poplar_test::options("held6")};
    auto const camera = support::lens(150, 70);
    graph.render(camera);
    auto const before = standin::all_runs(graph.mesh().engine()).host_copies;
    graph.render(camera);
    // In: the tiles that run, and the camera. Out: the log of tiles, the log of the run, counters, pair counters, framebuffers.
    CHECK(standin::all_runs(graph.mesh().engine()).host_copies - before == 2 + 5);
    // Words that the host accessed for writing are copied to the device once.
    graph.mesh().state<splat::Counts>(TileId::at(0, 0)).visible += 0;
    auto const again = standin::all_runs(graph.mesh().engine()).host_copies;
    graph.render(camera);
    CHECK(standin::all_runs(graph.mesh().engine()).host_copies - again == 2 + 5 + 1);
}

TEST_CASE("poplar: traces, and so modelled cycles, are those of the thread engine")
{
    standin::With const restore(standin::settings());
    standin::settings().tile_bytes = 64u << 20;
    auto const map = support::map_of(support::cloud(support::fast() ? 100 : 300, 5));
    RendererOptions options;
    options.tile = {20, 16};
    for (auto const& e : executions) {
        CAPTURE(e.name);
        poplar_test::use(e);
        BasicRenderer<Watched> threads{map, options};
        BasicRenderer<Watched, PoplarMesh> graph{map, options, poplar_test::options("watched")};
        for (float turn : {0.0f, 0.04f, 0.04f}) {
            threads.render(support::lens(150, 70, turn));
            graph.render(support::lens(150, 70, turn));
            CHECK(graph.mesh().trace() == threads.mesh().trace());
        }
        CHECK(threads.mesh().trace().supersteps.size() >= 4);
    }
}

TEST_CASE("poplar: worker order and count change nothing; starved channels, drop, bounded hops")
{
    standin::With const restore(standin::settings());
    standin::settings().tile_bytes = 64u << 20;
    auto const map = support::map_of(support::cloud(support::fast() ? 150 : 500, 11));
    std::vector<splat::Camera> cameras;
    for (float turn : {0.0f, 0.02f, 0.3f, 0.3f}) cameras.push_back(support::lens(150, 70, turn)); // the last frame is static
    RendererOptions options;
    options.tile = {20, 16};
    for (auto const& e : executions) {
        CAPTURE(e.name);
        poplar_test::use(e);
        // The first execution closes the memory of all other tiles. Sanitizers have their own check.
        standin::settings().isolation = &e == executions && !support::fast() ? standin::Isolation::pages : standin::Isolation::none;
        compare<Held<1>>(map, "held1", options, cameras);
        compare<Held<6>>(map, "held6", options, cameras);
        compare<Dropped>(map, "dropped4", options, cameras);
        options.hops = 1;
        compare<Held<6>>(map, "held6", options, cameras);
        options.hops = 0;
    }
    // Other sizes than those of the codelets' setup: codelets serve any sizes.
    auto sizes = Held<6>::sizes;
    sizes.storage = 230;
    sizes.road = 3;
    sizes.beam = 9;
    sizes.waiting = 2;
    options.sizes = sizes;
    poplar_test::use(executions[0]);
    compare<Held<6>>(map, "held6", options, cameras);
    options.sizes.reset();
    // The rules of training on a background, floats and 8-bit pixels.
    options.quality = splat::Quality::training;
    options.background = std::array<float, 3>{0.75f, 0.25f, 0.5f};
    compare<Held<6>>(map, "held6", options, cameras);
    compare<Dropped>(map, "dropped4", options, cameras);
    options.quality.reset();
    options.background.reset();
    // Limits below the slots of the layout.
    options.channel_slots = 2;
    options.storage_slots = 200;
    options.waiting_slots = 3;
    poplar_test::use(executions[1]);
    compare<Held<6>>(map, "held6", options, cameras);
    // The picture of one worker is that of six workers.
    BasicRenderer<Held<1>, PoplarMesh> one{map, options, poplar_test::options("held1")};
    BasicRenderer<Held<6>, PoplarMesh> six{map, options, poplar_test::options("held6")};
    CHECK(support::differing_pixels(one.render(cameras[0]).image, six.render(cameras[0]).image) == 0);
}
