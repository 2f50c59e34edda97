// test: unoptimised test asan tsan
// Records that move between two frames, to where the next view is expected to want them: pictures keep their bits, no id is lost, and what
// moved early need not move in the frame.
#include "../compare_reports.hpp"
#include "../splat/runner.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/render/frame_renderer.hpp>
#include <tilemesh/track/pose_update.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
using render::HostPolicies, render::HostRenderer;
using support::Room;

namespace {

HostRenderer::EngineOptions engine(bool trace, bool checked)
{
    HostRenderer::EngineOptions e;
    e.trace = trace;
    if (checked) e.make = make_checked_port<HostRenderer::Program>;
    return e;
}
template <class S>
HostRenderer make(scene::Map const& map, RendererOptions const& options, bool trace = false, bool checked = false)
{
    return HostRenderer(map, render::setup_for<S>(options), options, engine(trace, checked));
}
scene::Map cloud(std::uint32_t n, std::uint64_t seed) { return support::map_of(support::cloud(n, seed)); }

/// Every id that is on the mesh or missing, once.
bool conserved(HostRenderer& renderer, scene::Map const& map, report::FrameReport const& last)
{
    auto const owned = support::owned_ids<HostPolicies>(renderer.mesh());
    return std::adjacent_find(owned.begin(), owned.end()) == owned.end() &&
           owned.size() + last.gaussians.unplaced == map.gaussians.size();
}
/// The copies of records that are not on the mesh.
std::uint32_t orphans(HostRenderer& renderer)
{
    auto const owned = support::owned_ids<HostPolicies>(renderer.mesh());
    std::uint32_t n = 0;
    for (TileId const tile : renderer.mesh().grid().tiles())
        for (auto const& mark : std::as_const(renderer.mesh()).state<Marks<HostPolicies>>(tile))
            n += !std::binary_search(owned.begin(), owned.end(), static_cast<std::uint32_t>(mark.id));
    return n;
}
std::uint32_t wrong_tiles(HostRenderer& renderer, scene::Map const& map, Camera const& camera)
{
    return support::wrong_tiles<HostPolicies>(renderer.mesh(), map.gaussians, make_view(camera, renderer.rules()), renderer.tiling());
}

constexpr std::size_t looks_away = 7;
/// A hand-held path: it goes on, turns back, stands still, and jumps away and back.
std::vector<Camera> path(std::uint32_t width, std::uint32_t height)
{
    std::vector<Camera> out;
    for (float const turn : {0.0f, 0.03f, 0.06f, 0.09f, 0.05f, 0.05f, 0.05f, 3.1f, 0.01f, 0.02f})
        out.push_back(support::lens(width, height, turn));
    return out;
}

/// Renders the path with and without prefetch. `expected(cameras, i)`: the camera that is expected for frame i. No motion comes before the
/// first frame.
template <class S, class Expected>
void same_pictures(scene::Map const& map, RendererOptions const& options, bool checked, Expected const& expected)
{
    auto early = make<S>(map, options, false, checked), plain = make<S>(map, options, false, checked);
    auto const cameras = path(96, 64);
    RenderedFrame with, without;
    std::uint64_t exchanges = 0, moved = 0;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        INFO("frame ", i);
        if (i > 0) {
            auto const p = early.prefetch(expected(cameras, i));
            exchanges += p.exchanges;
            moved += p.moved;
            CHECK(conserved(early, map, {}));
        }
        early.render_into(cameras[i], with);
        plain.render_into(cameras[i], without);
        CHECK(support::differing_pixels(with.image, without.image) == 0);
        CHECK(with.depth.values == without.depth.values);
        CHECK(with.alpha.values == without.alpha.values);
        CHECK(with.report.lost.empty());
        CHECK(with.report.pairs == without.report.pairs);
        CHECK((with.report.pairs_contributing > 500) == (i != looks_away));
        CHECK(with.report.copies == without.report.copies);
        CHECK(with.report.gaussians.visible == without.report.gaussians.visible);
        CHECK(conserved(early, map, with.report));
        CHECK(wrong_tiles(early, map, cameras[i]) == 0);
    }
    CHECK(exchanges > 10);
    CHECK(moved > 10);
}
Camera by_motion(std::vector<Camera> const& cameras, std::size_t i)
{
    return track::predicted(cameras[i < 2 ? 0 : i - 2], cameras[i - 1]);
}
/// Anything but what comes.
Camera far_off(std::vector<Camera> const& cameras, std::size_t i)
{
    return support::lens(cameras[i].width, cameras[i].height, i % 2 == 0 ? -0.7f : 0.5f);
}

/// The sentence with which a prefetch is refused; empty if it is not.
std::string refusal(HostRenderer& renderer, Camera const& camera)
{
    return tests::error_of([&] { (void)renderer.prefetch(camera); });
}
std::set<std::string> kernels_of(Trace const& trace)
{
    std::set<std::string> names;
    for (auto const& s : trace.supersteps) names.insert(trace.kernels[s.step]);
    return names;
}

} // namespace

TEST_CASE("prefetch: pictures and copies are those of frames without it, for right and wrong guesses, both engines, any number of threads")
{
    auto const map = cloud(150, 1596);
    for (auto const& guess : {by_motion, far_off}) {
        for (std::uint32_t threads : {1u, 3u}) same_pictures<Room<>>(map, {.threads = threads, .tile = {11, 9}}, false, guess);
        same_pictures<Room<>>(map, {.tile = {16, 10}}, true, guess);
    }
    same_pictures<support::Planes>(map, {.tile = {16, 10}}, false, by_motion);
    same_pictures<support::Screens>(map, {.tile = {16, 10}}, false, by_motion);
    same_pictures<support::LargestHold>(map, {.tile = {16, 10}}, false, far_off);
}

TEST_CASE("prefetch: with one slot in every channel and FIFO")
{
    auto const map = cloud(100, 1597);
    for (auto const& guess : {by_motion, far_off})
        same_pictures<Room<>>(map, {.tile = {11, 9}, .channel_slots = 1, .waiting_slots = 1}, false, guess);
}

TEST_CASE("prefetch: a frame in the expected view exchanges nothing; the prefetch exchanged all of it")
{
    auto const map = cloud(150, 1598);
    auto early = make<Room<>>(map, {.tile = {11, 9}}), plain = make<Room<>>(map, {.tile = {11, 9}});
    auto const first = support::lens(96, 64), next = support::lens(96, 64, 0.05f);
    (void)early.render(first);
    (void)plain.render(first);
    auto const p = early.prefetch(next);
    auto const with = early.render(next), without = plain.render(next);
    CHECK(support::differing_pixels(with.image, without.image) == 0);
    CHECK(support::differing_pixels(with.image, report::render_naive(map.gaussians, next, plain.rules())) == 0);
    CHECK(without.report.exchanges.total() > 2);
    CHECK(p.exchanges == without.report.exchanges.total());
    CHECK(p.messages == without.report.messages);
    CHECK(p.exchanged_live_bytes == without.report.exchanged_live_bytes);
    CHECK(p.moved == without.report.gaussians.moved);
    CHECK(with.report.exchanges.total() == 0);
    CHECK(with.report.gaussians.moved == 0);
    CHECK(with.report.messages == 0);
    // The frame is one in a new view: every tile composites, once.
    CHECK(early.composited_tiles() == early.tiling().columns * early.tiling().rows);
    CHECK(with.report.passes.composite == without.report.passes.composite);
}

TEST_CASE("prefetch: where the tile's list stays and only its order changes, the frame in the expected view sorts")
{
    // Two balls behind each other. The turn swaps which one is nearer.
    std::vector<Gaussian> const balls{{{-0.1f, 0, 2}, {1, 0, 0}, 0.9f, {1, 0, 0, 0}, {-1.5f, -1.5f, -1.5f}, GaussianId{1}},
                                      {{0.1f, 0, 2}, {0, 1, 0}, 0.9f, {1, 0, 0, 0}, {-1.5f, -1.5f, -1.5f}, GaussianId{2}}};
    auto const first = support::lens(96, 64, -0.1f), next = support::lens(96, 64, 0.1f);
    auto early = make<Room<>>(support::map_of(balls), {.tile = {96, 64}});
    auto const before = early.render(first);
    auto const p = early.prefetch(next);
    CHECK(p.messages == 0);
    auto const after = early.render(next);
    CHECK(support::differing_pixels(after.image, report::render_naive(balls, next, early.rules())) == 0);
    auto const red_in_front = [](RenderedFrame const& f) { return f.image.pixel(48, 32)[0] > f.image.pixel(48, 32)[1]; };
    CHECK(red_in_front(before) != red_in_front(after));
}

TEST_CASE("prefetch: a wrong guess before a frame in the old view moves back, also where no tile's list changed")
{
    auto const map = cloud(150, 1599);
    auto const camera = support::lens(96, 64);
    for (float const turn : {0.5f, 1e-6f}) {
        auto early = make<Room<>>(map, {.tile = {11, 9}});
        auto const before = early.render(camera);
        auto const p = early.prefetch(support::lens(96, 64, turn));
        CHECK((p.messages == 0) == (turn < 0.1f));
        auto const after = early.render(camera);
        CHECK(support::differing_pixels(after.image, before.image) == 0);
        CHECK(after.report.pairs == before.report.pairs);
        CHECK(wrong_tiles(early, map, camera) == 0);
        auto const still = early.render(camera);
        CHECK(support::differing_pixels(still.image, before.image) == 0);
        CHECK(early.composited_tiles() == 0);
        CHECK(still.report.exchanges.total() == 0);
    }
}

TEST_CASE("prefetch: nothing runs for a camera that stands still, and it may come before the first frame")
{
    auto const map = cloud(150, 1600);
    auto early = make<Room<>>(map, {.tile = {11, 9}}, true), plain = make<Room<>>(map, {.tile = {11, 9}}, true);
    auto const camera = support::lens(96, 64);
    auto const cold = early.prefetch(camera);
    CHECK(conserved(early, map, {}));
    CHECK(wrong_tiles(early, map, camera) == 0);
    CHECK(kernels_of(early.trace()) == std::set<std::string>{"project", "route", "bloom"});
    auto const with = early.render(camera), without = plain.render(camera);
    CHECK(cold.exchanges == without.report.exchanges.total());
    CHECK(with.report.exchanges.total() == 0);
    CHECK(support::differing_pixels(with.image, without.image) == 0);
    CHECK(kernels_of(early.trace()).count("depth sort") == 1);
    CHECK(early.trace().supersteps.size() < plain.trace().supersteps.size());

    auto const again = early.prefetch(track::predicted(camera, camera));
    CHECK(again.exchanges + again.messages + again.exchanged_live_bytes + again.moved == 0);
    CHECK(early.trace().supersteps.empty());
    auto const still = early.render(camera), still_plain = plain.render(camera);
    CHECK(report::first_difference(still.report, still_plain.report) == "");
    CHECK(early.composited_tiles() == 0);
}

TEST_CASE("prefetch: a lost pose is refused before a record moves, and the next frame is that of a renderer that was not asked")
{
    auto const map = cloud(150, 1601);
    auto early = make<Room<>>(map, {.tile = {11, 9}}), plain = make<Room<>>(map, {.tile = {11, 9}});
    auto const first = support::lens(96, 64), next = support::lens(96, 64, 0.05f);
    (void)early.render(first);
    (void)plain.render(first);
    auto lost = first;
    lost.position[1] = std::numeric_limits<float>::quiet_NaN();
    CHECK(refusal(early, lost) != "");
    auto const with = early.render(next), without = plain.render(next);
    CHECK(support::differing_pixels(with.image, without.image) == 0);
    CHECK(report::first_difference(with.report, without.report) == "");
}

TEST_CASE("prefetch: refused where moving records early could change a picture")
{
    auto const map = cloud(30, 1602);
    auto const says = [](HostRenderer renderer, std::string const& why) {
        CHECK(refusal(renderer, support::lens(96, 64)) == "prefetch with " + why + "; render without it, or choose `lossless`");
    };
    says(make<support::Dropping>(map, {.tile = {16, 10}}), "setup paper (it drops records that find no room, also those that move early)");
    says(make<support::NoRouting>(map, {.tile = {16, 10}}), "setup lossless (it does not route: the host places its records in each view)");
    says(make<Room<>>(map, {.tile = {16, 10}, .hops = 2}), "bounded hops (a frame that is cut depends on where its records were before)");
}

TEST_CASE("prefetch: on full tiles no id is lost, and each picture lacks what its frame lists")
{
    auto const map = cloud(250, 1603);
    for (bool const right : {true, false}) {
        RendererOptions options{.tile = {11, 9}};
        options.sizes = support::sized<Room<>>(8, 10);
        auto early = make<Room<>>(map, options);
        auto const cameras = path(96, 64);
        std::uint64_t lost = 0, absent = 0; // of frames, and of prefetches
        for (std::size_t i = 0; i < cameras.size(); ++i) {
            INFO("frame ", i);
            if (i > 0) {
                (void)early.prefetch(right ? by_motion(cameras, i) : far_off(cameras, i));
                CHECK(orphans(early) == 0);
                absent += map.gaussians.size() - support::owned_ids<HostPolicies>(early.mesh()).size();
            }
            auto const frame = early.render(cameras[i]);
            CHECK(conserved(early, map, frame.report));
            support::Missing const missing(frame.report, early.tiling(), early.mesh().grid());
            auto const shown = report::render_naive(map.gaussians, cameras[i], early.rules(), missing);
            CHECK(support::differing_pixels(frame.image, shown) == 0);
            lost += frame.report.lost.size();
        }
        CHECK(lost > 0);
        CHECK(absent > 0);
    }
}
