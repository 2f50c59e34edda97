// test: unoptimised test asan, cost 4
#include "../standard.hpp"
#include <tilemesh/basic_renderer.hpp>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/render/homes_layout.hpp>
#include <tilemesh/render/homes_renderer.hpp>
#include <tilemesh/renderer.hpp>
#include <tilemesh/report/naive.hpp>
#include <tilemesh/scene/demand.hpp>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>

using namespace tilemesh;
using report::Program;

namespace {
/// 120 Gaussians in a small cloud in front of the camera.
scene::Map cloud()
{
    scene::Map map;
    for (std::uint32_t i = 0; i < 120; ++i) {
        float const x = 0.004f * static_cast<float>(i % 12) - 0.022f, y = 0.004f * static_cast<float>(i / 12) - 0.018f;
        constexpr float size = -7.6f; // 0.0005
        map.gaussians.push_back({{x, y, 2 + 0.001f * static_cast<float>(i * 7 % 120)},
                                 {0.5f, static_cast<float>(i) / 120, 0.25f},
                                 0.4f,
                                 {1, 0, 0, 0},
                                 {size, size, size},
                                 splat::GaussianId{i + 1}});
    }
    return map;
}
/// `focal` px: at 2,400 the cloud fills the frame; at 24 it lies in one block.
splat::Camera camera(float focal)
{
    return {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}, focal, focal, 40, 22.5f, 0.2f, 64, 40}; // the principal point is in the middle of a block
}
RendererOptions options(std::uint32_t storage, Program program = Program::automatic)
{
    return {.grid = {4, 4}, .storage_slots = storage, .arithmetic = splat::Arithmetic::precise, .program = program};
}
bool same(report::Image const& a, report::Image const& b)
{
    return a.rgb.size() == b.rgb.size() && std::memcmp(a.rgb.data(), b.rgb.data(), a.rgb.size() * sizeof a.rgb[0]) == 0;
}
} // namespace

TEST_SUITE_BEGIN("render");

TEST_CASE("auto renders with anchored tiles until a frame would lose something, then with homes for good")
{
    auto const map = cloud();
    Renderer renderer(map, options(60));
    auto const wide = renderer.render(camera(2400));
    CHECK(wide.report.program == Program::anchored);
    CHECK(wide.report.homes.rounds == 0);
    CHECK(renderer.change().empty());

    auto const crowd = renderer.render(camera(24));
    CHECK(crowd.report.program == Program::homes);
    CHECK(crowd.report.homes.rounds >= 1);
    CHECK(crowd.report.homes.unfinished_tiles == 0);
    CHECK(crowd.report.lost.empty());
    CHECK(renderer.change().find("would be missing") != std::string::npos);
    CHECK(same(crowd.image, report::render_naive(map.gaussians, camera(24), renderer.rules())));

    auto const again = renderer.render(camera(24));
    CHECK(again.report.program == Program::homes);
    CHECK(again.report.passes.total() == 0); // an unchanged view runs no superstep
    CHECK(again.report.exchanges.total() == 0);
    CHECK(same(again.image, crowd.image));
    auto const back = renderer.render(camera(2400)); // anchored tiles would have room again
    CHECK(back.report.program == Program::homes);
    CHECK(same(back.image, wide.image));
}

TEST_CASE("auto: an observer's Error in the first frame of homes comes out, and the next frame tries homes again")
{
    Renderer renderer(cloud(), options(60));
    auto const of_homes = [&] { return renderer.core().setup().program == splat::Program::homes; };
    renderer.observe([&](SuperstepEvent const&) {
        if (of_homes()) throw Error("enough (of this); stop");
    });
    CHECK_THROWS_WITH_AS((void)renderer.render(camera(24)), "enough (of this); stop", Error);
    CHECK(renderer.change_refused().empty());
    int refused = 0;
    renderer.observe([&](SuperstepEvent const&) {
        try {
            if (of_homes()) (void)renderer.render(camera(2400));
        } catch (Error const&) {
            ++refused;
        }
    });
    auto const crowd = renderer.render(camera(24));
    CHECK(refused > 0);
    CHECK(crowd.report.program == Program::homes);
    CHECK(same(crowd.image, Renderer(cloud(), options(60)).render(camera(24)).image));
}

TEST_CASE("each program alone, and a map with more records than anchored tiles have slots")
{
    auto const map = cloud();
    auto o = options(60, Program::anchored);
    CHECK_FALSE(Renderer(map, o).render(camera(24)).report.lost.empty());
    o.program = Program::homes;
    auto const homes = Renderer(map, o).render(camera(24));
    CHECK(homes.report.program == Program::homes);
    CHECK(homes.report.peak_storage <= 60);
    o.program = Program::automatic;
    o.storage_slots = 7; // 16 tiles have 112 slots for 120 records
    Renderer renderer(map, o);
    auto const few = renderer.render(camera(24));
    CHECK(few.report.program == Program::homes);
    CHECK(renderer.change() == "the records have no room");
    CHECK(few.report.homes.rounds > homes.report.homes.rounds);
    CHECK(same(few.image, homes.image));
    o.held_slots = 50; // of homes; storage_slots is the anchored tiles'
    auto const more = Renderer(map, o).render(camera(24));
    CHECK(more.report.peak_storage > 7);
    CHECK(more.report.peak_storage <= 50);
    CHECK(same(few.image, more.image));
    o.storage_slots = 8; // 128 slots: the anchored program gets its chance
    CHECK(Renderer(map, o).render(camera(24)).report.program == Program::homes);
}

TEST_CASE("a bound on rounds leaves tiles unfinished, each exact up to its depth")
{
    auto const map = cloud();
    auto o = options(0, Program::homes);
    o.held_slots = 10;
    o.rounds = 2;
    Renderer renderer(map, o);
    auto const frame = renderer.render(camera(24));
    auto const& r = frame.report;
    CHECK(r.homes.rounds == 2);
    REQUIRE_FALSE(r.unfinished.empty());
    CHECK(r.unfinished.size() == r.homes.unfinished_tiles);
    auto const depth = report::nearest_cut(r).depth;
    CHECK(depth > 2);
    CHECK(depth < 2.12f);
    // No Gaussian lies behind the cut of the only crowded tile: then the frame is that of the Gaussians in front of it.
    auto front = map;
    std::erase_if(front.gaussians, [&](auto const& g) { return g.mean_world[2] >= depth; });
    REQUIRE(r.unfinished.size() == 1);
    CHECK(same(frame.image, report::render_naive(front.gaussians, camera(24), renderer.rules())));
    auto const still = renderer.render(camera(24));
    CHECK(still.report.unfinished == r.unfinished); // an unchanged view lacks the same
    CHECK(still.report.homes.rounds == 0);
}

TEST_CASE("options of the anchored program alone keep auto there, and homes refuse them")
{
    auto const map = cloud();
    auto o = options(20);
    o.grid = {};
    o.tile = {16, 10};
    auto const frame = Renderer(map, o).render(camera(24));
    CHECK(frame.report.program == Program::anchored);
    CHECK_FALSE(frame.report.lost.empty());
    o.program = Program::homes;
    CHECK_THROWS_AS(Renderer(map, o), Error);
    o = options(0, Program::homes);
    o.hops = 1;
    CHECK_THROWS_WITH_AS(Renderer(map, o), doctest::Contains("with hops (homes have no routing to end"), Error);
}

TEST_CASE("homes are as many as the map needs; held splats get what is left, or the map comes in chapters")
{
    auto c = splat::homes_setup;
    c.fit = true;
    RendererOptions o;
    Extent2 const frame{1280, 720};
    auto const small = render::layout_homes(c, o, frame, 1441);
    CHECK(small.setup.sizes.homes == 2);
    CHECK(small.setup.sizes.storage == c.sizes.storage);
    CHECK(render::sram_bytes_of(small.setup) <= c.machine.sram_bytes);
    auto const none = render::layout_homes(c, o, frame, 0);
    CHECK(none.setup.sizes.homes == 1);
    // More records: fewer held splats, down to the least; then chapters, with the most held splats.
    std::uint32_t last_held = c.sizes.storage, least = last_held;
    bool chapters = false;
    for (std::uint64_t records = 100'000; records <= 8'000'000; records += 100'000) {
        auto const layout = render::layout_homes(c, o, frame, records);
        CHECK(render::sram_bytes_of(layout.setup) <= c.machine.sram_bytes);
        if (std::uint64_t{layout.setup.sizes.homes} * layout.grid.size() < records) {
            chapters = true;
            CHECK(layout.setup.sizes.storage == c.sizes.storage);
        } else {
            CHECK_FALSE(chapters);
            CHECK(layout.setup.sizes.storage <= last_held);
            last_held = layout.setup.sizes.storage;
            least = std::min(least, layout.setup.sizes.storage);
        }
    }
    CHECK(chapters);
    CHECK(least < c.sizes.storage);
    CHECK(least >= render::least_held);
    o.held_slots = 5000;
    CHECK_THROWS_WITH_AS(render::layout_homes(c, o, frame, 1000),
                         "a limit of 5000 held splats (a tile has room for 2800); choose 1 to 2800", Error);
    o.grid = {64, 64};
    CHECK_THROWS_AS(render::layout_homes(c, o, frame, 1000), Error);
    CHECK_THROWS_AS(render::layout_homes(c, {}, {0, 720}, 1000), Error);
}

TEST_CASE("a frame whose pixels have no room on anchored tiles is of homes at once; a bad camera changes nothing")
{
    auto const map = cloud();
    Renderer renderer(map, {.threads = 2, .program = Program::automatic});
    auto large = camera(800);
    large.width = 1280, large.height = 720, large.cx = 640, large.cy = 360;
    CHECK(renderer.render(large).report.program == Program::anchored);
    large.width = 1281; // tiles of 33 x 20 pixels: 660 of 640
    auto bad = large;
    bad.cx = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_AS((void)renderer.render(bad), Error);
    auto const frame = renderer.render(large);
    CHECK(frame.report.program == Program::homes);
    CHECK(frame.report.lost.empty());
    CHECK(renderer.change() == "the pixels have no room");
    Renderer anchored(map, {.threads = 2, .program = Program::anchored});
    CHECK_THROWS_AS((void)anchored.render(large), Error);
}

TEST_CASE("an observer and the demand follow the change to homes, on both engines, with a trace")
{
    auto const map = cloud();
    for (auto const engine : {render::EngineKind::threads, render::EngineKind::checked}) {
        auto o = options(60);
        o.engine = engine;
        o.trace = true;
        Renderer renderer(map, o);
        std::vector<splat::Camera> const path{camera(2400), camera(24)};
        auto demand = scene::demand_of(map, std::span(path), renderer.rules(), [&](splat::Camera const& c) { return tiling_for(o, c.width, c.height); });
        demand.culled = 7; // as if so many were not loaded
        renderer.hold_to(demand);
        std::size_t seen = 0;
        bool of_homes = false;
        renderer.observe([&](SuperstepEvent const&) {
            ++seen;
            of_homes = dynamic_cast<render::HostHomesRenderer*>(&renderer.core()) != nullptr;
        });
        (void)renderer.render(camera(2400));
        CHECK(seen == renderer.trace().supersteps.size());
        CHECK_FALSE(of_homes);
        seen = 0;
        auto const crowd = renderer.render(camera(24));
        CHECK(crowd.report.program == Program::homes);
        CHECK(of_homes);
        CHECK(seen > renderer.trace().supersteps.size()); // those of the anchored program, too
        CHECK(crowd.report.gaussians.visible + crowd.report.gaussians.parked == map.gaussians.size() + demand.culled);
        CHECK_THROWS_WITH_AS((void)renderer.render(camera(500)), doctest::Contains("a view that the demand was not made for"), Error);
    }
}

TEST_CASE("one program and one engine by values, or a core of one's own: the same picture; what none keeps is refused")
{
    auto const map = cloud();
    auto const anchored = options(200, Program::anchored);
    Renderer by_options(map, anchored), by_setup(map, splat::lossless, anchored),
        own(std::make_unique<BasicRenderer<splat::Referenced<splat::Lossless>, PortMesh>>(map, anchored));
    auto const frame = by_options.render(camera(2400));
    CHECK(same(frame.image, by_setup.render(camera(2400)).image));
    CHECK(same(frame.image, own.render(camera(2400)).image));
    CHECK(by_options.grid().width == 4);
    CHECK_THROWS_AS((void)by_options.trace(), Error);
    auto homes = splat::as_homes(splat::lossless);
    Renderer by_homes(map, homes, anchored); // the setup names the program
    auto const crowd = by_homes.render(camera(2400));
    CHECK(crowd.report.program == Program::homes);
    CHECK(same(frame.image, crowd.image));
    CHECK_THROWS_AS((void)by_homes.prefetch(camera(24)), Error);
    auto drops = splat::lossless;
    drops.holds = false;
    CHECK_THROWS_WITH_AS(Renderer(map, drops, options(200, Program::homes)), doctest::Contains("with saturation drop (homes drop nothing"), Error);
}

TEST_SUITE_END();
