// test: unoptimised asan tsan
#include "runner.hpp"

using namespace tilemesh;
using namespace tilemesh::splat;
using support::Dropping, support::make_runner, support::Screens, support::sized, support::Whole;

namespace {
/// Renders a hand-held path over a cloud. After every frame it compares each tile's records with brute force.
template <class S, template <class, class> class Engine = PortMesh>
void check_copies(std::uint32_t slots, RendererOptions options, std::vector<float> const& turns)
{
    auto const gaussians = support::cloud(400, 21);
    options.sizes = sized<S>(slots, 400);
    auto const runner = make_runner<S, Engine>(support::map_of(gaussians), options);
    for (float turn : turns) {
        auto const camera = support::lens(120, 80, turn);
        auto const frame = runner->render(camera);
        CHECK(runner->wrong_tiles(gaussians, make_view(camera, runner->rules())) == 0);
        CHECK(frame.report.lost.empty());
        CHECK(support::differing_pixels(frame.image, report::render_naive(gaussians, camera, runner->rules())) == 0);
    }
}
std::vector<float> const path = {0, 0, 0.002f, 0.004f, 0.05f, -0.4f, 1.5f, 3.1f, 0.01f, 0.01f, 0.02f, -0.02f};
} // namespace

TEST_CASE("bloom: after every frame the copies equal the overlap set: channels of 1, 2, 5 and 300, both engines")
{
    check_copies<Whole>(1, {.grid = {7, 6}}, path);
    check_copies<Whole>(2, {.threads = 3, .grid = {5, 9}}, path);
    check_copies<Whole>(5, {.threads = 2, .grid = {12, 8}}, path);
    check_copies<Whole>(300, {.grid = {1, 1}}, path);
    check_copies<Whole, CheckedMesh>(1, {.grid = {4, 3}}, path);
    check_copies<Whole, CheckedMesh>(5, {.tile = {7, 13}}, path);
}

TEST_CASE("bloom: screen copies are good for one view and bloom anew for the next")
{
    check_copies<Screens>(5, {.grid = {7, 6}}, path);
    check_copies<Screens, CheckedMesh>(1, {.grid = {4, 3}}, path);
}

TEST_CASE("bloom: k tiles cost k - 1 messages, a static view none, and a footprint that leaves a tile frees its slot")
{
    // 9 x 9 tiles of 8 pixels; one ball whose box covers all of them.
    std::vector<Gaussian> const one{support::ball(1, 36, 36, 16, 0.9f)};
    auto const renderer = make_runner<Whole>(support::map_of(one), {.tile = {8, 8}, .sizes = sized<Whole>(8, 20)});
    auto camera = support::flat_camera(72, 72);
    auto const first = renderer->render(camera);
    CHECK(first.report.copies == 80);
    CHECK(first.report.messages - first.report.hops == 80);
    CHECK(first.report.exchanges.bloom == 8); // 4 along the row, 4 along the columns
    auto const again = renderer->render(camera);
    CHECK(again.report.messages == 0);
    CHECK(again.report.exchanges.total() == 0);
    CHECK(again.report.copies == 80);
    CHECK(again.report.exchanged_live_bytes == 0);
    CHECK(again.report.exchanged_capacity_bytes == 0);
    camera.position[2] = -7000; // eight times as far: a sigma of 2 pixels about pixel 4.5
    auto const far = renderer->render(camera);
    CHECK(far.report.copies == 3);
}

TEST_CASE("bloom: an anchor that moves by a tile costs the new copies, not the whole footprint")
{
    std::vector<Gaussian> const one{support::ball(1, 70, 70, 10, 0.9f)};
    auto const renderer = make_runner<Whole>(support::map_of(one), {.tile = {8, 8}, .sizes = sized<Whole>(40, 20)});
    auto camera = support::flat_camera(240, 240);
    (void)renderer->render(camera);
    for (auto const& [dx, dy] : {std::pair{8.0f, 0.0f}, {0.0f, 8.0f}}) {
        camera.position[0] -= dx;
        camera.position[1] -= dy;
        auto const r = renderer->render(camera).report;
        CHECK(r.gaussians.moved == 1);
        CHECK(r.copies > 60);
        CHECK(r.messages <= 1 + 2 * 11); // the record, a column or row of new copies, and at most one row that has them already
        CHECK(r.messages >= 9);
    }
}

TEST_CASE("drop: every missing copy is listed with its cause, and the picture lacks exactly these")
{
    auto gaussians = support::cloud(500, 31);
    auto const check = [&]<class S>(S, std::uint32_t slots, std::uint32_t records, report::Cause cause) {
        auto const renderer = make_runner<S>(support::map_of(gaussians), {.grid = {7, 6}, .sizes = sized<S>(slots, records)});
        for (float turn : {0.0f, 0.0f, 0.03f}) {
            auto const view = support::lens(120, 80, turn);
            auto const frame = renderer->render(view);
            auto const& r = frame.report;
            REQUIRE_FALSE(r.lost.empty());
            bool seen = false;
            for (auto const& l : r.lost) seen = seen || l.cause == cause;
            CHECK(seen);
            if (S::Saturation::holds) CHECK(r.lost_copies + r.gaussians.unplaced == r.lost.size());
            auto const full = report::render_naive(gaussians, view, renderer->rules());
            auto const without = report::render_naive(gaussians, view, renderer->rules(), renderer->missing(r));
            // RGBX8 or float: the format of the framebuffer.
            auto shown = without;
            if constexpr (std::is_same_v<typename S::Pixel, Rgbx8Pixel>)
                for (float& v : shown.rgb) v = static_cast<float>(Rgbx8Pixel::level(v)) / 255.0f;
            CHECK(support::differing_pixels(frame.image, shown) == 0);
            CHECK(support::differing_pixels(full, without) > 0);
        }
    };
    check(Dropping{}, 2, 600, report::Cause::channel_full);
    check(Dropping{}, 300, 22, report::Cause::storage_full);
    check(Whole{}, 300, 22, report::Cause::storage_full);
    // Records for two tiles on one anchor tile: some are unplaced, listed by id.
    for (auto& g : gaussians) g.mean_world[0] = g.mean_world[2] * 0.01f, g.mean_world[1] = g.mean_world[2] * 0.01f;
    check(Whole{}, 300, 60, report::Cause::unplaced);
}

TEST_CASE("hold: an unplaced record comes back when another view has room for it, and lost copies are sent again")
{
    auto const gaussians = support::cloud(500, 31);
    auto const renderer = make_runner<Whole>(support::map_of(gaussians), {.grid = {7, 6}, .sizes = sized<Whole>(300, 140)});
    auto near = support::lens(120, 80);
    auto far = near;
    far.position[2] = -30; // all on a few tiles
    auto const crowded = renderer->render(far);
    CHECK(crowded.report.gaussians.unplaced > 0);
    CHECK(renderer->render(far).report.gaussians.unplaced == crowded.report.gaussians.unplaced); // static: no record is tried again
    auto away = near; // in the other direction nothing is on screen, and all have room
    away.rotation[0][0] = away.rotation[2][2] = -1;
    auto const parked = renderer->render(away);
    CHECK(parked.report.gaussians.unplaced == 0);
    CHECK(parked.report.lost.empty());
    CHECK(parked.report.gaussians.parked == 500);
}

TEST_CASE("hold: unplaced records are visible in every frame, and in a static one too")
{
    // Three tiles of 16 slots, and 39 balls whose anchor is the first tile and whose footprints touch all three.
    std::vector<Gaussian> balls;
    for (std::uint32_t id = 1; id <= 39; ++id) balls.push_back(support::ball(id, 4, 4, 16, 0.5f));
    auto const renderer = make_runner<Whole>(support::map_of(balls), {.tile = {8, 8}, .sizes = sized<Whole>(40, 16)});
    auto camera = support::flat_camera(24, 8);
    for (int frame = 0; frame < 3; ++frame) { // the second and third are static
        CAPTURE(frame);
        auto const r = renderer->render(camera).report;
        CHECK(r.gaussians.visible == 39);
        CHECK(r.gaussians.parked == 0);
        CHECK(r.gaussians.unplaced == 23);
    }
    camera.rotation[0][0] = camera.rotation[2][2] = -1; // nothing is on screen, and all have room
    auto const r = renderer->render(camera).report;
    CHECK(r.gaussians.visible == 0);
    CHECK(r.gaussians.parked == 39);
    CHECK(r.gaussians.unplaced == 0);
}

TEST_CASE("every listed copy is lost or late, those of records that are nowhere or under way too")
{
    auto const gaussians = support::cloud(500, 31);
    auto const check = [&](std::unique_ptr<support::Runner> const& renderer) {
        std::uint64_t ownerless = 0, all_late = 0, gone = 0;
        for (float turn : {0.0f, 0.1f, 0.1f, 0.25f, 0.4f}) {
            auto const r = renderer->render(support::lens(120, 80, turn)).report;
            auto const owned = renderer->owned_ids(); // including those under way
            std::uint64_t lost = 0, late = 0;
            for (auto const& l : r.lost) {
                if (l.tile == report::Loss::whole) continue;
                ++(l.cause == report::Cause::late ? late : lost);
                ownerless += std::binary_search(owned.begin(), owned.end(), static_cast<std::uint32_t>(l.id)) ? 0 : 1;
            }
            CHECK(r.lost_copies == lost);
            CHECK(r.late_copies == late);
            CHECK(r.gaussians.visible + r.gaussians.parked + gone == 500);
            gone = r.gaussians.dropped;
            all_late += late;
        }
        return std::pair{ownerless, all_late};
    };
    auto const dropped = check(make_runner<Dropping>(support::map_of(gaussians), {.grid = {7, 6}, .sizes = sized<Dropping>(300, 22)}));
    CHECK(dropped.first > 0);
    CHECK(dropped.second == 0);
    auto const bounded = check(make_runner<Whole>(support::map_of(gaussians), {.grid = {7, 6}, .hops = 1, .sizes = sized<Whole>(2, 400)}));
    CHECK(bounded.second > 0);
}

TEST_CASE("hold: `held` counts every wait, for a slot as for a credit, of one frame")
{
    auto const renderer = make_runner<Whole>(support::map_of(support::cloud(400, 21)), {.grid = {7, 6}, .sizes = sized<Whole>(1, 400)});
    auto const r = renderer->render(support::lens(120, 80)).report;
    CHECK(r.refused.channel_full > 0);
    CHECK(r.refused.no_credit > 0);
    CHECK(r.gaussians.held == r.refused.by_channels());
    CHECK(r.gaussians.dropped == 0);
    CHECK(renderer->render(support::lens(120, 80)).report.gaussians.held == 0); // in a static view no record waits
}

TEST_CASE("drop: copies that a full channel refused are owed again in the next view, and no others are")
{
    auto const gaussians = support::cloud(250, 53);
    auto const renderer = make_runner<Dropping>(support::map_of(gaussians), {.grid = {7, 6}, .sizes = sized<Dropping>(2, 600)});
    auto camera = support::lens(96, 80);
    auto const first = renderer->render(camera).report;
    REQUIRE(first.lost_copies > 50);
    auto before = first;
    std::uint32_t frames = 0;
    for (; frames < 200 && before.lost_copies != 0; ++frames) {
        camera.cx += 1e-4f; // a new view in which almost nothing moves
        auto const now = renderer->render(camera).report;
        CHECK(now.messages <= before.lost_copies + 20); // an anchor or two may cross a border
        CHECK(now.lost_copies <= before.lost_copies + 5);
        before = now;
    }
    CHECK(before.lost_copies == 0);
    CHECK(frames > 1);
    auto const again = renderer->render(camera).report;
    CHECK(again.lost.empty());
    CHECK(again.messages == 0);
}

TEST_CASE("bounded hops: one superstep a frame; every frame lacks exactly the listed copies, and a static view converges")
{
    auto const gaussians = support::cloud(300, 41);
    auto const map = support::map_of(gaussians);
    auto const options = [](std::uint32_t slots, std::uint32_t hops) {
        return RendererOptions{.grid = {8, 6}, .hops = hops, .sizes = sized<Whole>(slots, 400)};
    };
    auto const check = [&](std::unique_ptr<support::Runner> const& renderer, std::uint32_t hops) {
        std::uint64_t late = 0, under_way = 0;
        for (float turn : {0.0f, 0.3f, 0.31f, -1.0f, 0.2f}) { // each starts while records of the one before are still under way
            std::uint64_t missing = 1, frames = 0;
            std::uint32_t const patience = turn == 0.31f ? 400 : 3;
            for (; frames < patience && missing != 0; ++frames) {
                auto const camera = support::lens(120, 80, turn);
                auto const frame = renderer->render(camera);
                auto const& r = frame.report;
                CHECK(r.exchanges.route <= hops);
                CHECK(r.exchanges.bloom <= hops);
                auto const ids = renderer->owned_ids();
                CHECK(ids.size() == gaussians.size());
                CHECK(std::adjacent_find(ids.begin(), ids.end()) == ids.end());
                auto const without = report::render_naive(gaussians, camera, renderer->rules(), renderer->missing(r));
                CHECK(support::differing_pixels(frame.image, without) == 0);
                for (auto const& l : r.lost) CHECK(l.cause == report::Cause::late);
                late += r.late_copies;
                under_way += r.gaussians.under_way;
                missing = r.lost.size() + r.gaussians.under_way;
            }
            if (patience == 400) {
                CHECK(missing == 0);
                CHECK(frames > 3); // it took several frames
            }
        }
        CHECK(late > 0);
        CHECK(under_way > 0);
    };
    check(make_runner<Whole>(map, options(300, 1)), 1);
    check(make_runner<Whole>(map, options(2, 1)), 1);
    check(make_runner<Whole>(map, options(2, 3)), 3);
    check(make_runner<Screens>(map, options(300, 1)), 1);
    check(make_runner<Whole, CheckedMesh>(map, options(2, 1)), 1);
}

TEST_CASE("bounded hops: views that change while records are under way never leave two waiting for each other")
{
    // FIFOs of one slot, and a new view every frame: two records meet that both must turn back.
    auto const gaussians = support::cloud(200, 43);
    for (std::uint64_t seed = 0; seed < (support::fast() ? 4u : 24u); ++seed) {
        auto const renderer = make_runner<Whole>(support::map_of(gaussians), {.grid = {5, 4}, .hops = seed % 3 == 2 ? 2u : 1u, .sizes = sized<Whole>(1, 300)});
        support::Random random(seed);
        for (int i = 0; i < 40; ++i) (void)renderer->render(support::lens(60, 48, random.uniform(-1, 1)));
        std::uint64_t missing = 1;
        for (int i = 0; i < 600 && missing != 0; ++i) {
            auto const r = renderer->render(support::lens(60, 48, 0.1f)).report;
            missing = r.lost.size() + r.gaussians.under_way;
        }
        INFO("seed ", seed);
        CHECK(missing == 0);
    }
}

TEST_CASE("bounded hops: records without storage are listed tile by tile, and come back without doubling")
{
    auto const gaussians = support::cloud(400, 47);
    std::uint64_t unplaced = 0;
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
        auto const renderer = make_runner<Whole>(support::map_of(gaussians), {.grid = {5, 4}, .hops = 2, .sizes = sized<Whole>(5, 30)});
        support::Random random(seed);
        for (int i = 0; i < 40; ++i) {
            auto const camera = support::lens(60, 48, random.uniform(-0.6f, 0.6f));
            auto const frame = renderer->render(camera);
            auto const& r = frame.report;
            unplaced += r.gaussians.unplaced;
            auto const ids = renderer->owned_ids();
            CHECK(ids.size() + r.gaussians.unplaced == gaussians.size());
            CHECK(std::adjacent_find(ids.begin(), ids.end()) == ids.end());
            CHECK(support::differing_pixels(
                      frame.image, report::render_naive(gaussians, camera, renderer->rules(),
                                                        renderer->missing(r))) == 0);
        }
    }
    CHECK(unplaced > 0);
}
