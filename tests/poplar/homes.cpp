// test: unoptimised test asan, without tsan
#include "../compare_reports.hpp"
#include "../splat/support.hpp"
#include "on_poplar.hpp"
#include <array>
#include <tilemesh/render/homes_renderer.hpp>

// The program of homes as codelets on a graph, on the stand-in for Poplar: it gives the pictures, counters and words of the thread engine.
using namespace tilemesh;
namespace homes = splat::homes;
using poplar_test::executions;

namespace {
using ByValue = homes::ValuePolicies<>;
using Threads = render::HomesRenderer<ByValue>;
using OnGraph = render::HomesRenderer<ByValue, PoplarMesh, Mk2>; // the vertices of examples/on_poplar/codelets.cpp

/// Homes for half of the records, if the map comes in `chapters`. Tiles hold 8 splats, channels 4.
render::Setup choice_of(scene::Map const& map, Grid grid, bool chapters)
{
    auto c = splat::homes_setup;
    auto const share = static_cast<std::uint32_t>(map.gaussians.size()) / grid.size() + 1;
    c.sizes = splat::homes::homes_sizes(chapters ? share / 2 + 1 : share, 8, 4, 3);
    return c;
}
void compare(scene::Map const& map, Grid grid, bool chapters, RendererOptions options)
{
    options.grid = {grid.width, grid.height};
    auto const choice = choice_of(map, grid, chapters);
    Threads threads(map, choice, options);
    OnGraph graph(map, choice, options, poplar_test::options("homes"));
    for (float const turn : {0.0f, 0.3f}) {
        auto const view = support::lens(75, 38, turn);
        auto const expected = threads.render(view), frame = graph.render(view);
        CHECK(support::differing_pixels(frame.image, expected.image) == 0);
        CHECK(report::first_difference(frame.report, expected.report) == "");
        if (options.rounds == 0) CHECK(support::differing_pixels(frame.image, report::render_naive(map.gaussians, view, threads.rules())) == 0);
        CHECK((expected.report.homes.chapters > 1) == chapters);
        CHECK(expected.report.homes.rounds > 1);
        poplar_test::check_same_words(threads.mesh(), graph.mesh());
    }
    CHECK(graph.render(support::lens(75, 38, 0.3f)).report.passes.total() == 0); // an unchanged view
}
} // namespace

TEST_CASE("poplar: the program of homes has the pictures, counters and words of the thread engine, in every order of workers")
{
    standin::Restore const restore;
    auto const map = support::map_of(support::cloud(support::fast() ? 120 : 200, 31));
    for (auto const& e : executions) {
        CAPTURE(e.name);
        poplar_test::use(e);
        compare(map, {4, 3}, false, {});
    }
    poplar_test::use(executions[2]);
    compare(map, {3, 2}, true, {});
    compare(map, {1, 5}, false, {});
    compare(map, {3, 2}, true, {.quality = splat::Quality::training, .background = std::array<float, 3>{0.75f, 0.25f, 0.5f}});
    RendererOptions options;
    options.fold = false;
    options.channel_slots = options.waiting_slots = 1;
    options.storage_slots = 3;
    compare(map, {5, 2}, false, options);
    options.rounds = 3;
    compare(map, {3, 3}, false, options);
    // All chapters share a bound: this one cuts the last chapter.
    options.grid = {3, 3};
    options.rounds = 0;
    auto const all = Threads(map, choice_of(map, {3, 3}, true), options).render(support::lens(75, 38)).report.homes.rounds;
    options.rounds = static_cast<std::uint32_t>(all) - 1;
    compare(map, {3, 3}, true, options);
}

TEST_CASE("poplar: the graph of homes has the variables of its ledger, byte for byte")
{
    auto const map = support::map_of(support::cloud(50, 32));
    RendererOptions options;
    options.grid = {4, 3};
    standin::Restore const restore;
    OnGraph graph(map, choice_of(map, {4, 3}, false), options, poplar_test::options("homes"));
    graph.render(support::lens(75, 38));
    auto found = standin::tile_bytes(graph.mesh().engine(), 0).variables;
    for (auto const& line : render::ledger_of(graph.setup()))
        if (std::string(line.what) != "reserve") CHECK(poplar_test::take(found, line) == line.bytes);
}
