// test: unoptimised test asan tsan
// A tile whose splats and view did not change keeps its pixels: pictures, counters, digests and traces are those of a renderer whose tiles
// all composite in every frame, and exactly the tiles that must composite do so.
#include "../compare_reports.hpp"
#include "../splat/support.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/render/kept_pixels.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;
using support::Room;

namespace {

using render::FrameRenderer, render::HostPolicies, render::HostRenderer;
/// The renderer of all setups by reference, with or without a trace, on threads or sequential.
template <bool Trace, bool Checked>
struct On : HostRenderer {
    static constexpr bool keeps_trace = Trace;
    On(scene::Map const& map, render::Setup facts, RendererOptions const& options) : HostRenderer(map, std::move(facts), options, engine()) {}
    static EngineOptions engine()
    {
        EngineOptions engine;
        engine.trace = Trace;
        if (Checked) engine.make = make_checked_port<Program>;
        return engine;
    }
};
using OnThreads = On<false, false>;
using WithTrace = On<true, false>;
using Sequential = On<false, true>;

template <class S>
struct Screens : Room<S> {
    using Copies = ScreenCopies;
};

/// Two renderers of one map: the tiles of the first keep their pixels, those of the second composite in every frame.
template <class Renderer>
struct Twins {
    Renderer keeps, composites;
    RenderedFrame kept, all;

    template <class Setup>
    Twins(Setup, scene::Map const& map, RendererOptions options)
        : keeps(map, render::setup_for<Setup>(options), with(options, true)),
          composites(map, render::setup_for<Setup>(options), with(options, false))
    {
    }
    static RendererOptions with(RendererOptions options, bool keep)
    {
        options.digest = true;
        options.keep_pixels = keep;
        return options;
    }
    std::uint32_t tiles() const { return keeps.tiling().columns * keeps.tiling().rows; }

    /// Renders a frame with both, and compares everything that a frame has. Returns the number of tiles that composited.
    std::uint32_t render(Camera const& camera)
    {
        keeps.render_into(camera, kept);
        composites.render_into(camera, all);
        CHECK(support::differing_pixels(kept.image, all.image) == 0);
        CHECK(kept.depth.values == all.depth.values);
        CHECK(kept.alpha.values == all.alpha.values);
        CHECK(report::first_difference(kept.report, all.report) == "");
        CHECK(kept.report.digests == all.report.digests);
        CHECK(!kept.report.digests.empty());
        std::uint32_t other_work = 0;
        for (TileId const tile : keeps.mesh().grid().tiles()) {
            auto const &a = keeps.mesh().template state<Work>(tile), &b = composites.mesh().template state<Work>(tile);
            other_work += std::memcmp(&a, &b, sizeof a) != 0;
        }
        CHECK(other_work == 0);
        if constexpr (Renderer::keeps_trace) CHECK(keeps.trace() == composites.trace());
        CHECK(composites.composited_tiles() % tiles() == 0);
        CHECK(composites.composited_tiles() > 0);
        return keeps.composited_tiles();
    }
    /// Does every tile composite in the next frame?
    bool all_composite(Camera const& camera)
    {
        auto const composited = render(camera); // there is no tiling before
        return composited == tiles() && composited > 0;
    }
    /// Every tile composites, and in the frame after that none.
    void all_composite_once(Camera const& camera)
    {
        CHECK(all_composite(camera));
        CHECK(render(camera) == 0);
    }
};

/// Static, moved, static, teleported, back. Each view is new at its first frame only.
template <class Renderer, class Setup>
void same_sequence(Setup setup, scene::Map const& map, RendererOptions const& options)
{
    Twins<Renderer> twins(setup, map, options);
    float last = -1;
    for (float const turn : {0.0f, 0.0f, 0.0f, 0.02f, 0.02f, -0.4f, -0.4f, 0.0f, 0.0f}) {
        INFO("turn ", turn, ", threads ", options.threads, ", tile ", options.tile.width, " x ", options.tile.height);
        auto const composited = twins.render(support::lens(67, 41, turn));
        CHECK(composited == (turn == last ? 0 : twins.tiles()));
        CHECK(twins.kept.report.pairs_contributing > 500);
        last = turn;
    }
}
scene::Map cloud(std::uint32_t n, std::uint64_t seed) { return support::map_of(support::cloud(n, seed)); }

} // namespace

TEST_CASE("kept pixels: pictures, counters and digests of tiles that all composite, over tilings and threads")
{
    auto const map = cloud(150, 301);
    for (Extent2 const tile : {Extent2{16, 20}, {7, 13}, {67, 41}})
        for (std::uint32_t threads : {1u, 2u, 3u}) same_sequence<OnThreads>(Room<>{}, map, {.threads = threads, .tile = tile});
    same_sequence<OnThreads>(Room<>{}, map, {.threads = 2, .tile = {9, 9}, .arithmetic = Arithmetic::fast});
}

TEST_CASE("kept pixels: 8-bit colours with drop, and projected copies")
{
    auto const map = cloud(150, 302);
    same_sequence<OnThreads>(Room<Paper>{}, map, {.threads = 2, .tile = {9, 9}});
    same_sequence<OnThreads>(Screens<Lossless>{}, map, {.tile = {9, 9}});
}

TEST_CASE("kept pixels: planes of depth and alpha")
{
    using Both = WithPixel<Room<>, WithAlpha<WithDepth<FloatPixel>>>;
    auto const map = cloud(150, 303);
    for (std::uint32_t threads : {1u, 3u}) same_sequence<OnThreads>(Both{}, map, {.threads = threads, .tile = {16, 10}});
}

TEST_CASE("kept pixels: the sequential engine")
{
    same_sequence<Sequential>(Room<>{}, cloud(80, 304), {.tile = {16, 10}});
}

TEST_CASE("kept pixels: the trace is that of tiles that all composite")
{
    for (std::uint32_t threads : {1u, 2u}) same_sequence<WithTrace>(Room<>{}, cloud(100, 305), {.threads = threads, .tile = {16, 10}});
}

TEST_CASE("kept pixels: a record that arrives late composites the tiles that it touches, and no other")
{
    // One hop a frame. The record starts on tile 0, because the host deals one record to the first tile. It is anchored on tile 5 and touches
    // tile 6 too. Bloom sends the copy in the frame after the arrival.
    auto const camera = support::flat_camera(80, 10);
    std::vector<Gaussian> const ball{support::ball(1, 59, 5, 1.5f)};
    Twins<OnThreads> twins(Room<>{}, support::map_of(ball), {.tile = {10, 10}, .hops = 1});
    CHECK(twins.render(camera) == 8);
    std::vector<std::uint32_t> composited, late;
    for (int frame = 0; frame < 9; ++frame) {
        composited.push_back(twins.render(camera));
        late.push_back(static_cast<std::uint32_t>(twins.kept.report.lost.size()));
    }
    CHECK(*std::max_element(composited.begin(), composited.end()) == 1);
    CHECK(std::accumulate(composited.begin(), composited.end(), 0u) == 2);
    CHECK(late.front() > 0);
    CHECK(late.back() == 0);
    CHECK(composited.back() == 0);
    CHECK(support::differing_pixels(twins.kept.image, report::render_naive(ball, camera, twins.keeps.rules())) == 0);
}

TEST_CASE("kept pixels: in a static view, the tiles that composite are those whose records changed")
{
    // A cloud under way with few hops a frame and channels of 4 slots. The slots of every tile are compared from frame to frame.
    auto const camera = support::lens(120, 80);
    Twins<OnThreads> twins(Room<>{}, cloud(400, 306), {.threads = 2, .tile = {10, 10}, .hops = 2, .channel_slots = 4});
    auto const slots = [&] {
        std::vector<std::set<std::uint32_t>> out;
        for (TileId const tile : twins.keeps.mesh().grid().tiles()) {
            auto& ids = out.emplace_back();
            for (auto const& mark : std::as_const(twins.keeps.mesh()).state<Marks<HostPolicies>>(tile))
                ids.insert(static_cast<std::uint32_t>(mark.id) << 1 | (mark.is(Mark::copy) ? 1u : 0u));
        }
        return out;
    };
    CHECK(twins.all_composite(camera));
    auto last = slots();
    std::uint32_t some = 0, none = 0, frames = 0;
    for (; none < 2 && frames < 400; ++frames) {
        auto const composited = twins.render(camera);
        auto now = slots();
        std::uint32_t changed = 0;
        for (std::size_t t = 0; t < now.size(); ++t) changed += now[t] != last[t];
        last = std::move(now);
        // A record may come and go within two passes of a frame: such a tile composites although its slots are the old ones.
        CHECK(composited >= changed);
        CHECK(composited <= twins.tiles());
        some += composited > 0 && composited < twins.tiles();
        none = composited == 0 && twins.kept.report.lost.empty() ? none + 1 : 0;
    }
    CHECK(some > 3);
    CHECK(none == 2);
    CHECK(support::differing_pixels(twins.kept.image, report::render_naive(support::cloud(400, 306), camera, twins.keeps.rules())) == 0);
}

TEST_CASE("kept pixels: a frame that runs twice composites only the tiles whose copies were recalled")
{
    // Too little storage: some records find no room on their anchor tile, and the host recalls their copies.
    std::uint32_t twice = 0;
    for (std::uint32_t const slots : {22u, 60u}) {
        Twins<OnThreads> twins(Room<>{}, cloud(500, 31), {.threads = 2, .grid = {7, 6}, .storage_slots = slots});
        float last = 1;
        for (float const z : {0.0f, 0.0f, -30.0f, -30.0f, -29.0f, 0.0f, 0.0f, -10.0f, 0.5f, -0.5f, -1.0f, -1.0f}) {
            INFO("slots ", slots, ", z ", z);
            auto camera = support::lens(120, 80);
            camera.position[2] = z;
            auto const composited = twins.render(camera), first_run = z == last ? 0 : twins.tiles();
            last = z;
            if (twins.composites.composited_tiles() == twins.tiles()) {
                CHECK(composited == first_run);
            } else {
                ++twice;
                CHECK(composited > first_run);
                CHECK(composited < first_run + twins.tiles());
            }
        }
    }
    CHECK(twice > 0);
}

TEST_CASE("kept pixels: after a frame that threw, every tile composites")
{
    for (std::uint32_t const at : {0u, 3u, 5u}) { // in project, in bloom, after composite
        Twins<OnThreads> twins(Room<>{}, cloud(150, 308), {.threads = 2, .tile = {16, 10}});
        auto const camera = support::lens(67, 41);
        twins.all_composite_once(camera);
        for (auto* const renderer : {&twins.keeps, &twins.composites}) {
            renderer->observe([at](SuperstepEvent const& event) {
                if (event.step >= at) throw std::runtime_error("enough");
            });
            RenderedFrame frame;
            CHECK_THROWS_AS(renderer->render_into(camera, frame), std::runtime_error);
            renderer->observe({});
        }
        twins.all_composite_once(camera);
    }
}

TEST_CASE("kept pixels: another size, also one that is only prepared, and other rules composite every tile")
{
    Twins<OnThreads> twins(Room<>{}, cloud(150, 309), {.grid = {6, 5}});
    auto const camera = support::lens(67, 41);
    twins.all_composite_once(camera);
    for (auto* const renderer : {&twins.keeps, &twins.composites}) { // the same grid, so the mesh stays and its framebuffers become black
        renderer->prepare(60, 40);
        renderer->prepare(67, 41);
    }
    twins.all_composite_once(camera);
    CHECK(twins.all_composite(support::lens(66, 41)));
    CHECK(twins.all_composite(camera));
    auto const change = [&](auto const& with) {
        auto const before = twins.keeps.rules();
        with(twins.keeps.rules());
        with(twins.composites.rules());
        twins.all_composite_once(camera);
        twins.keeps.rules() = twins.composites.rules() = before;
        twins.all_composite_once(camera);
    };
    change([](Rules& m) { m = with_quality(m, Quality::on_sensor); });
    change([](Rules& m) { m.alpha_max = 0.5f; });
    change([](Rules& m) { m.transmittance_min = 0.25f; });
    change([](Rules& m) { m.arithmetic = Arithmetic::fast; });
    change([](Rules& m) { m.footprint = Footprint::three_sigma_square; });
    change([](Rules& m) { m.dilation = 0; });
}

TEST_CASE("kept pixels: two renderers of different maps do not share them")
{
    Twins<OnThreads> one(Room<>{}, cloud(150, 310), {.tile = {16, 10}}), other(Room<>{}, cloud(150, 311), {.tile = {16, 10}});
    auto const camera = support::lens(67, 41);
    for (int frame = 0; frame < 2; ++frame) {
        CHECK((frame == 0 ? one.all_composite(camera) : one.render(camera) == 0));
        CHECK((frame == 0 ? other.all_composite(camera) : other.render(camera) == 0));
        CHECK(support::differing_pixels(one.kept.image, other.kept.image) > 0);
    }
}

TEST_CASE("kept pixels: each byte of the parameters counts, except the flags and the address that compositing does not read")
{
    Grid const grid{3, 2};
    auto const tiling = make_tiling(30, 20, 10, 10);
    TableParameters frame{};
    frame.view = make_view(support::lens(30, 20), Rules{});
    frame.tiling = tiling;
    auto const bytes = reinterpret_cast<unsigned char*>(&frame);
    auto const is_flag = [&](std::size_t at) {
        auto const offset = [&](std::uint8_t const& member) { return static_cast<std::size_t>(reinterpret_cast<unsigned char const*>(&member) - bytes); };
        auto const before_at = static_cast<std::size_t>(reinterpret_cast<unsigned char const*>(&frame.before) - bytes);
        bool const of_before = at >= before_at && at < before_at + sizeof frame.before;
        return of_before || at == offset(frame.view_changed) || at == offset(frame.resend_copies) || at == offset(frame.readdress);
    };
    auto const stale_at = static_cast<std::size_t>(reinterpret_cast<unsigned char*>(&frame.stale) - bytes);
    render::KeptPixels kept(true);
    auto const composited = [&] {
        kept.begin_run(frame, grid);
        return kept.composited(tiling, grid);
    };
    CHECK(composited() == 6);
    CHECK(composited() == 0);
    std::uint32_t flags = 0;
    for (std::size_t at = 0; at < sizeof frame; ++at) {
        if (at >= stale_at && at < stale_at + sizeof frame.stale) continue; // the address of the tiles' bytes, which begin_run writes
        for (int bit : {0, 7}) {
            auto const flip = [&] { bytes[at] ^= static_cast<unsigned char>(1u << bit); };
            flip();
            INFO("byte ", at, ", bit ", bit);
            CHECK(composited() == (is_flag(at) ? 0 : 6));
            CHECK(composited() == 0);
            flip();
            (void)composited();
        }
        flags += is_flag(at);
    }
    CHECK(flags == 3 + sizeof frame.before);
    kept.forget();
    CHECK(composited() == 6);
    // A grid of another size has bytes of its own.
    kept.begin_run(frame, Grid{40, 36});
    CHECK(kept.composited(make_tiling(400, 360, 10, 10), Grid{40, 36}) == 1440);
}

TEST_CASE("kept pixels: the switch, and renderers that always composite")
{
    render::KeptPixels forced(false);
    TableParameters frame{};
    forced.begin_run(frame, Grid{3, 2});
    CHECK(frame.stale.get() == nullptr);
    CHECK(forced.composited(make_tiling(20, 20, 10, 10), Grid{3, 2}) == 4);
    CHECK(Access<TableParameters>::keeps_pixels({TileId::at(0, 0), Grid{3, 2}}, frame) == false);
    CHECK(Access<FrameParameters>::keeps_pixels({TileId::at(0, 0), Grid{3, 2}}, frame) == false);
    static_assert(render::may_keep_pixels<HostPolicies> && render::may_keep_pixels<PoliciesOf<Referenced<Lossless>>>);
    static_assert(!render::may_keep_pixels<PoliciesOf<Lossless>>, "by value, the parameters are the machine's");
    Twins<OnThreads> twins(Room<>{}, cloud(50, 312), {.tile = {16, 10}});
    CHECK(twins.keeps.composited_tiles() == 0); // no frame yet
    for (int i = 0; i < 2; ++i) {
        (void)twins.render(support::lens(67, 41));
        CHECK(twins.composites.composited_tiles() == twins.tiles());
    }
}
