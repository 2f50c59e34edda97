// test: unoptimised test asan tsan, cost 10
#include "runner.hpp"
#include "stand_ins.hpp"
#include <tilemesh/joined_threads.hpp>
#include <tilemesh/render/homes_renderer.hpp>
#include <tilemesh/scene/built_in.hpp>
#include <tilemesh/scene/frame_whole.hpp>
#include <tilemesh/scene/orbit.hpp>

using namespace tilemesh;
namespace homes = splat::homes;

namespace {
using Rows = render::HomesRenderer<homes::HostPolicies<>>;
using Values = render::HomesRenderer<homes::ValuePolicies<>>;

scene::Map every(std::uint32_t n)
{
    auto map = scene::built_in_map();
    scene::Map some;
    some.name = map.name;
    for (std::size_t i = 0; i < map.gaussians.size(); i += n) some.gaussians.push_back(map.gaussians[i]);
    return some;
}
render::Setup choice(scene::Map const& map, Grid grid)
{
    auto c = splat::homes_setup;
    c.machine.sram_bytes = 1u << 26;
    c.sizes.homes = static_cast<std::uint32_t>(map.gaussians.size()) / grid.size() + 1;
    return c;
}
using support::differing_pixels;
} // namespace

TEST_CASE("every block has one tile, and an interval of blocks is an interval of tiles")
{
    for (std::uint32_t tiles = 1; tiles < 7; ++tiles)
        for (std::uint32_t blocks = 1; blocks < 30; ++blocks)
            for (bool const folded : {false, true}) {
                auto const axis = homes::make_axis(blocks, tiles, folded);
                REQUIRE(axis.tiles <= tiles);
                std::vector<std::uint32_t> owners(blocks);
                for (std::uint32_t t = 0; t < axis.tiles; ++t)
                    for (std::uint32_t k = 0; k < axis.layers; ++k)
                        if (auto const b = axis.block(t, k); b < blocks) {
                            ++owners[b];
                            CHECK(axis.tile_of(b) == t);
                        }
                CHECK(owners == std::vector<std::uint32_t>(blocks, 1));
                for (std::uint32_t i = 0; i < blocks; ++i)
                    for (std::uint32_t j = i; j < blocks; ++j) {
                        auto low = axis.tile_of(i), high = low;
                        for (std::uint32_t b = i; b <= j; ++b) {
                            low = std::min(low, axis.tile_of(b));
                            high = std::max(high, axis.tile_of(b));
                        }
                        auto const range = axis.tiles_of(i, j);
                        CHECK(range.first == low);
                        CHECK(range.last == high);
                    }
            }
}

TEST_CASE("the picture is that of the naive loop, for any capacities, folded or not, on every engine")
{
    auto const map = every(40);
    Grid const grid{4, 3};
    using splat::Arithmetic, splat::Stop;
    struct Case {
        std::uint32_t held, slots, waiting;
        bool fold;
        Arithmetic arithmetic = Arithmetic::precise;
        Stop stop = Stop::after_crossing;
    };
    for (auto const& c : {Case{2000, 120, 120, true}, Case{100, 3, 2, true}, Case{17, 2, 1, false}, Case{1, 1, 1, true},
                          Case{40, 120, 120, true, Arithmetic::fast}, Case{40, 120, 120, true, Arithmetic::fast, Stop::before_crossing}}) {
        auto const m = c.held == 1 ? every(200) : map;
        RendererOptions o{.grid = grid,
                          .channel_slots = c.slots,
                          .waiting_slots = c.waiting,
                          .storage_slots = c.held,
                          .arithmetic = c.arithmetic,
                          .digest = true,
                          .fold = c.fold};
        auto setup = choice(m, grid);
        setup.rules.stop = c.stop;
        auto const base = scene::frame_whole(m, {90, 53});
        auto const views = scene::orbit(base, scene::robust_centre(m), 5, 2);
        Rows rows(m, setup, o);
        o.threads = 3;
        Rows shared(m, setup, o);
        Values values(m, setup, o);
        render::HomesRenderer<homes::HostPolicies<>, CheckedMesh> checked(m, setup, o);
        for (auto const& view : views) {
            auto const a = rows.render(view), b = shared.render(view), v = values.render(view), d = checked.render(view);
            if (c.arithmetic == Arithmetic::precise) CHECK(differing_pixels(a.image, report::render_naive(m.gaussians, view, rows.rules())) == 0);
            for (auto const* other : {&b, &v, &d}) {
                CHECK(differing_pixels(a.image, other->image) == 0);
                CHECK(a.report.pairs == other->report.pairs);
                CHECK(a.report.pairs_contributing == other->report.pairs_contributing);
                CHECK(a.report.hops == other->report.hops);
            }
            CHECK(a.report.digests == b.report.digests);
            CHECK(a.report.digests == d.report.digests);
            CHECK(a.report.pairs_contributing > 0);
            CHECK(a.report.homes.unfinished_tiles == 0);
            CHECK(a.report.peak_storage <= c.held);
        }
        CHECK(rows.render(views.back()).report.passes.total() == 0); // an unchanged view
    }
}

TEST_CASE("a crowd on one tile: n splats arrive n log n times at most, in the first view and in the next one, and the picture is the naive loop's")
{
    Grid const grid{4, 3};
    auto view = support::flat_camera(64, 15); // a block a tile
    view.fx = view.fy = 60;
    view.cx = 24, view.cy = 7.5f;
    RendererOptions const o{.grid = grid, .storage_slots = 40};
    for (std::uint32_t const n : {1500u, 6000u}) {
        scene::Map map;
        std::mt19937 random{n};
        for (std::uint32_t i = 0; i < n; ++i) { // behind one pixel, and too faint to hide another
            auto g = support::ball(i + 1, 0, 0, std::exp(-7.0f), 0.1f);
            g.mean_world[2] = 2 + static_cast<float>(random() % 100000) / 10000;
            for (auto& colour : g.colour) colour = static_cast<float>(random() % 100) / 100;
            map.gaussians.push_back(g);
        }
        Rows renderer(map, choice(map, grid), o);
        auto moved = view;
        moved.cx += 0.25f;
        for (auto const& camera : {view, moved}) {
            auto const frame = renderer.render(camera);
            auto const& counted = frame.report.homes;
            CHECK(differing_pixels(frame.image, report::render_naive(map.gaussians, camera, renderer.rules())) == 0);
            CHECK(counted.unfinished_tiles == 0);
            CHECK(counted.rounds > n / 40); // every one goes through the tile
            CHECK(counted.entries <= 4 * n); // 2.5 and 3; without cuts that stay 7 and 27
        }
    }
}

TEST_CASE("a map with more records than homes comes in chapters, and the picture is the same")
{
    auto map = every(60);
    for (std::size_t i = 0; i < map.gaussians.size(); i += 3) // equal depths, so that a chapter ends between two ids
        for (int c = 0; c < 3; ++c) map.gaussians[i].mean_world[c] = map.gaussians[0].mean_world[c];
    Grid const grid{4, 3};
    RendererOptions const o{.grid = grid, .storage_slots = 60};
    auto const view = scene::frame_whole(map, {90, 53}), next = scene::orbit(view, scene::robust_centre(map), 30, 2)[1];
    auto c = choice(map, grid);
    Rows whole(map, c, o);
    for (std::uint32_t const slots : {0u, 1u, 3u, 10u}) {
        c.sizes.homes = slots;
        Rows chapters(map, c, o);
        Values values(map, c, o);
        if (slots == 0) {
            CHECK_THROWS_AS(chapters.render(view), Error);
            continue;
        }
        for (auto const& camera : {view, next}) {
            auto const a = whole.render(camera), b = chapters.render(camera), v = values.render(camera);
            CHECK(differing_pixels(a.image, b.image) == 0);
            CHECK(differing_pixels(a.image, v.image) == 0);
            CHECK(a.report.homes.chapters == 0);
            auto const in_front = std::count_if(map.gaussians.begin(), map.gaussians.end(), [&](auto const& g) {
                return splat::depth_key(g, splat::make_view(camera, whole.rules())) != 0;
            });
            auto const homes = slots * grid.size();
            CHECK(b.report.homes.chapters == (static_cast<std::uint32_t>(in_front) + homes - 1) / homes);
            CHECK(b.report.homes.streamed_bytes == static_cast<std::uint64_t>(in_front) * 60);
            CHECK(b.report.gaussians.visible == a.report.gaussians.visible);
            CHECK(b.report.hops == v.report.hops);
        }
        auto const again = chapters.render(next);
        CHECK(again.report.passes.total() == 0);
        CHECK(again.report.homes.streamed_bytes == 0);
    }
}

TEST_CASE("a bound on rounds is one of the frame: all chapters share it, and one round less leaves tiles unfinished")
{
    auto const map = every(60);
    Grid const grid{4, 3};
    RendererOptions o{.grid = grid, .storage_slots = 15};
    auto c = choice(map, grid);
    c.sizes.homes = 10;
    auto const view = scene::frame_whole(map, {90, 53});
    auto const whole = Rows(map, c, o).render(view);
    auto const rounds = static_cast<std::uint32_t>(whole.report.homes.rounds);
    auto const chapters = whole.report.homes.chapters;
    REQUIRE(chapters > 2);
    REQUIRE(rounds > 2 * chapters); // so that a bound is above what one chapter takes
    for (std::uint32_t const bound : {1u, 2u, rounds / 2, rounds - 1, rounds, rounds + 1}) {
        CAPTURE(bound);
        o.rounds = bound;
        Rows renderer(map, c, o);
        auto const frame = renderer.render(view);
        CHECK(frame.report.homes.rounds == std::min(bound, rounds));
        CHECK((frame.report.homes.unfinished_tiles != 0) == (bound < rounds));
        CHECK(frame.report.unfinished.size() == frame.report.homes.unfinished_tiles);
        CHECK((differing_pixels(frame.image, whole.image) == 0) == (bound >= rounds));
        auto const still = renderer.render(view);
        CHECK(still.report.unfinished == frame.report.unfinished);
        // The next view has all of its rounds.
        auto const next = renderer.render(scene::orbit(view, scene::robust_centre(map), 30, 2)[1]);
        CHECK(next.report.homes.rounds >= std::min(bound, 3u));
    }
}

TEST_CASE("threads with a renderer each do not disturb each other: anchored tiles and homes, each with two threads of its own")
{
    auto const map = every(200);
    Grid const grid{4, 3};
    RendererOptions const o{.threads = 2, .grid = grid, .storage_slots = 60};
    auto const views = scene::orbit(scene::frame_whole(map, {90, 53}), scene::robust_centre(map), 5, 2);
    auto const pictures = [&](bool anchored) {
        std::vector<RenderedFrame> frames;
        if (anchored) {
            auto const renderer = support::make_runner<support::Whole>(map, o);
            for (auto const& view : views) frames.push_back(renderer->render(view));
        } else {
            Rows renderer(map, choice(map, grid), o);
            for (auto const& view : views) frames.push_back(renderer.render(view));
        }
        return frames;
    };
    std::vector<RenderedFrame> const alone[] = {pictures(false), pictures(true)};
    std::vector<RenderedFrame> together[4];
    {
        JoinedThreads threads;
        for (std::size_t i = 0; i < std::size(together); ++i) threads.start([&, i] { together[i] = pictures(i % 2 != 0); });
    }
    for (std::size_t i = 0; i < std::size(together); ++i)
        for (std::size_t v = 0; v < views.size(); ++v) {
            REQUIRE(together[i].size() == views.size());
            CHECK(differing_pixels(together[i][v].image, alone[i % 2][v].image) == 0);
            CHECK(together[i][v].report.passes.total() == alone[i % 2][v].report.passes.total());
            CHECK(together[i][v].report.pairs == alone[i % 2][v].report.pairs);
        }
}
