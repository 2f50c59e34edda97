// test: without test asan tsan, cost 15
// Lent strips: neighbours blend blocks of a tile that has more to blend. No bit of the picture changes.
#include "runner.hpp"
#include <algorithm>
#include <doctest/doctest.h>
#include <tilemesh/splat/lending.hpp>
#include <type_traits>

using namespace tilemesh;
using namespace tilemesh::splat;
using support::differing_pixels;
using support::make_runner;
using support::Whole;

namespace {
using Lending = support::Room<LosslessLending>;
/// A setup of other policies that also lends strips.
template <class Base>
struct WithLending : Base {
    using Blending = LendsStrips<>;
};

/// A splat that covers these pixels of `flat_camera`, so far as rectangles say.
Splat rectangle(std::uint32_t x0, std::uint32_t x1, std::uint32_t y0, std::uint32_t y1)
{
    Splat s{};
    s.columns = x0 | x1 << 16;
    s.rows = y0 | y1 << 16;
    return s;
}
Rules precise()
{
    Rules rules;
    rules.arithmetic = Arithmetic::precise;
    return rules;
}
/// The loads of a tile of 32 x 20 pixels with `n[i]` splats in block i: 4 strips of 2 blocks.
BlockLoads loads_of(std::array<std::uint32_t, 8> const& n)
{
    BlockLoads loads(BlockGrid({32, 64, 20, 40}, precise()));
    for (std::uint32_t i = 0; i < 8; ++i)
        for (std::uint32_t k = 0; k < n[i]; ++k) loads.add(rectangle(32 + i % 2 * 16, 33 + i % 2 * 16, 20 + i / 2 * 5, 21 + i / 2 * 5));
    return loads;
}
LentStrips chosen(BlockLoads const& loads, splat::detail::Offers const& offers)
{
    LentStrips lent{};
    lent.last = loads.grid.strips;
    splat::detail::choose_strips(loads, offers, lent);
    return lent;
}

template <class S, template <class, class> class Engine>
struct Machine {
    using P = PoliciesOf<S>;
    BasicRenderer<S, Engine> renderer;
    std::uint32_t slots;

    Machine(scene::Map const& map, RendererOptions const& options, std::uint32_t most) : renderer(map, options), slots(most) {}
    RenderedFrame render(Camera const& camera)
    {
        renderer.prepare(camera.width, camera.height);
        if (slots != 0) {
            renderer.mesh().template limit<LentSplats<P>>(slots);
            renderer.mesh().template limit<LentPixels<P>>(slots);
        }
        slots = 0;
        return renderer.render(camera);
    }
    /// The strips that tiles lent in the last frame.
    std::uint32_t lent()
    {
        std::uint32_t n = 0;
        auto const& mesh = std::as_const(renderer.mesh());
        for (std::uint32_t t = 0; t < mesh.grid().size(); ++t) {
            auto const tile = mesh.grid().tile(t);
            auto const& of = mesh.template state<LentStrips>(tile);
            for (std::uint32_t strip : of.strip) n += strip != 0 ? 1 : 0;
            CHECK(of.guest == 0);
            CHECK(mesh.template state<GuestPixels<P>>(tile).empty());
            CHECK(mesh.template state<Splats<P>>(tile).size() == mesh.template state<Storage<P>>(tile).size());
        }
        return n;
    }
};

/// A cloud, and a heap of small splats in one place.
std::vector<Gaussian> heap()
{
    auto all = support::cloud(200, 77);
    support::Random random(5);
    for (std::uint32_t i = 0; i < 120; ++i) {
        auto g = all[i];
        g.mean_world[0] = random.uniform(-0.1f, 0.15f);
        g.mean_world[1] = random.uniform(-0.15f, 0.1f);
        g.mean_world[2] = 1.5f;
        g.opacity = 0.1f;
        for (float& s : g.log_scale) s = -3.5f;
        g.id = GaussianId{1001 + i};
        all.push_back(g);
    }
    return all;
}

/// Renders a path with lent strips and without: same bits, counters, ids. Returns the strips that were lent.
template <class S, template <class, class> class Engine, class Plain = support::Referenced<Whole>>
std::uint32_t check_identity(RendererOptions const& options, std::uint32_t slots, Arithmetic arithmetic)
{
    auto const gaussians = heap();
    auto const map = support::map_of(gaussians);
    auto const plain = make_runner<Plain>(map, options);
    Machine<S, Engine> lending(map, options, slots);
    plain->rules().arithmetic = lending.renderer.rules().arithmetic = arithmetic;
    std::uint32_t lent = 0;
    for (float turn : {0.0f, 0.0f, 0.03f, -0.4f, 0.01f}) {
        INFO("grid ", options.grid.width, " x ", options.grid.height, ", slots ", slots, ", turn ", turn);
        auto const camera = support::lens(120, 80, turn);
        auto const before = plain->render(camera), after = lending.render(camera);
        auto const strips = lending.lent();
        lent += strips;
        CHECK(after.report.exchanges.composite >= (strips != 0 ? 4u : options.grid.width * options.grid.height == 1 ? 0u : 1u));
        CHECK(differing_pixels(before.image, after.image) == 0);
        if (arithmetic == Arithmetic::precise) {
            auto const shown = report::render_naive(gaussians, camera, lending.renderer.rules(), plain->missing(before.report));
            CHECK(differing_pixels(after.image, shown) == 0);
        }
        CHECK(before.report.pairs == after.report.pairs);
        CHECK(before.report.pairs_contributing == after.report.pairs_contributing);
        CHECK(before.report.lost.size() == after.report.lost.size());
        CHECK(before.report.exchanges.route == after.report.exchanges.route);
        CHECK(before.report.exchanges.bloom == after.report.exchanges.bloom);
        CHECK(plain->owned_ids() == support::owned_ids<PoliciesOf<S>>(lending.renderer.mesh()));
    }
    return lent;
}
} // namespace

TEST_CASE("lending: the blocks of a tile and the loads of its workers")
{
    BlockGrid const grid({30, 64, 18, 40}, precise()); // borders that cut blocks
    CHECK(grid.across == 3);
    CHECK(grid.strips == 5);
    CHECK(grid.rect(0, 1).y0 == 18);
    CHECK(grid.rect(0, 1).y1 == 20);
    CHECK(grid.rect(4, 5).y1 == 40);
    CHECK(grid.strips_of(rectangle(0, 30, 18, 40)).last == 0); // beside the tile
    CHECK(grid.strips_of(rectangle(0, 31, 0, 21)).last == 2);
    CHECK(grid.strips_of(rectangle(63, 90, 39, 90)).first == 4);
    CHECK(BlockGrid({32, 64, 20, 40}, Rules{}).takes_part());
    Rules fast;
    fast.arithmetic = Arithmetic::fast;
    CHECK(BlockGrid({32, 64, 20, 40}, fast).across * BlockGrid({32, 64, 20, 40}, fast).strips == 20);
    CHECK_FALSE(BlockGrid({0, 1280, 0, 720}, precise()).takes_part());
    CHECK_FALSE(BlockGrid({0, 0, 0, 0}, precise()).takes_part());

    auto const loads = loads_of({1, 2, 3, 4, 5, 6, 7, 8});
    auto const of = loads.load(0, 4);
    CHECK(of.of[0] == 8); // blocks 0 and 6
    CHECK(of.of[1] == 10);
    CHECK(of.of[5] == 6);
    CHECK(of.most() == 10);
    CHECK(of.least(2) == 2);
    CHECK(of.most_of(of.least(2), 2) == 4);
    CHECK(of.most_of(5, 2) == 8); // worker 5, then worker 0
    CHECK(loads.load(0, 3).most() == 6);
    CHECK(loads.load(1, 4).of[0] == 3);
    CHECK(loads.splats[3] == 15);
    CHECK(loads.fullest(3) == 8);
    auto wide = loads_of({});
    wide.add(rectangle(0, 100, 0, 100));
    CHECK(wide.load(0, 4).most() == 2);
    CHECK(wide.splats[0] == 1);
}

TEST_CASE("lending: a tile lends to the least loaded first, and only while the larger load becomes smaller")
{
    LoadNotice const idle{0, 0, 100, 160}, no{0, 0, 0, 0};
    auto const even = loads_of({10, 10, 10, 10, 10, 10, 10, 10}); // a load of 20, and 10 for six blocks
    auto lent = chosen(even, {{idle, no, no, no}});
    CHECK(lent.strip[0] == 4);
    CHECK(lent.last == 3);
    CHECK(lent.loads.most() == 10);
    // A second helper would make no load smaller.
    lent = chosen(even, {{idle, idle, no, no}});
    CHECK(std::count(lent.strip, lent.strip + 4, 0u) == 3);
    // The least loaded is asked first, whatever its side.
    lent = chosen(even, {{{9, 5, 100, 160}, no, {8, 6, 100, 160}, no}});
    CHECK(lent.strip[2] == 4);
    CHECK(lent.strip[0] == 0);
    // The helper would have 10 beside 10: as much as the tile has now.
    CHECK(chosen(even, {{{19, 10, 100, 160}, no, no, no}}).strip[0] == 0);
    CHECK(chosen(even, {{{19, 9, 100, 160}, no, no, no}}).strip[0] == 4);
    // No room for the 20 splats of a strip, or for its 160 pixels.
    CHECK(chosen(even, {{{0, 0, 19, 160}, no, no, no}}).strip[0] == 0);
    CHECK(chosen(even, {{{0, 0, 20, 160}, no, no, no}}).strip[0] == 4);
    CHECK(chosen(even, {{{0, 0, 20, 159}, no, no, no}}).strip[0] == 0);
    // The upper border, if that is better: the helper would have 40 with the lower strip, and the tile has 35.
    lent = chosen(loads_of({5, 5, 5, 5, 5, 5, 30, 30}), {{no, no, no, {10, 10, 100, 160}}});
    CHECK(lent.strip[3] == 1);
    CHECK(lent.first == 1);
    CHECK(lent.last == 4);
    // A full block cannot be divided.
    CHECK(chosen(loads_of({1, 1, 40, 1, 1, 1, 1, 1}), {{idle, idle, idle, idle}}).last == 4);
}

TEST_CASE("lending: the picture, the pairs and the tiles of all records are those without it")
{
    using S = support::Referenced<Lending>;
    std::uint32_t lent = 0;
    for (std::uint32_t slots : {0u, 1u, 2u, 8u})
        lent += check_identity<S, Mesh>({.threads = 2, .grid = {5, 4}}, slots, Arithmetic::precise);
    CHECK(lent > 100);
    for (auto const grid : {Extent2{7, 6}, Extent2{4, 11}, Extent2{15, 2}, Extent2{1, 1}}) {
        auto const strips = check_identity<S, Mesh>({.threads = 1, .grid = {grid.width, grid.height}}, 2, Arithmetic::precise);
        CHECK((strips != 0) == (grid.width != 1));
    }
    CHECK(check_identity<S, Mesh>({.grid = {5, 4}}, 0, Arithmetic::fast) > 20);
    CHECK(check_identity<S, Mesh>({.grid = {3, 2}}, 0, Arithmetic::precise) == 0); // strips of 200 pixels
    // Storages with little room: what does not fit stays at home.
    auto const all = check_identity<S, Mesh>({.grid = {5, 4}}, 0, Arithmetic::precise);
    auto const fewer = check_identity<S, Mesh>({.grid = {5, 4}, .sizes = support::sized<Whole>(400, 30)}, 0, Arithmetic::precise);
    CHECK(fewer < all);
    CHECK(fewer != 0);
}

TEST_CASE("lending: beside other policies, with full channels, full storages and a bound on hops")
{
    using support::Screens;
    using support::Referenced, support::LargestHold, support::LargestDrop;
    using LendingHold = Referenced<WithLending<LargestHold>>;
    using LendingDrop = Referenced<WithLending<LargestDrop>>;
    for (std::uint32_t slots : {1u, 3u}) {
        RendererOptions const full{.grid = {5, 4}, .channel_slots = slots, .storage_slots = 60};
        RendererOptions const bounded{.grid = {7, 6}, .hops = 3, .channel_slots = slots, .storage_slots = 30};
        std::uint32_t lent = 0;
        for (auto const& options : {full, bounded}) {
            lent += check_identity<LendingHold, Mesh, Referenced<LargestHold>>(options, slots, Arithmetic::precise);
            lent += check_identity<LendingDrop, Mesh, Referenced<LargestDrop>>(options, slots, Arithmetic::precise);
            lent += check_identity<Referenced<WithLending<Screens>>, Mesh, Referenced<Screens>>(options, slots, Arithmetic::precise);
        }
        CHECK(lent > 60);
    }
}

TEST_CASE("lending: values, on the engine that checks every write")
{
    CHECK(check_identity<Lending, CheckedMesh>({.grid = {5, 4}}, 1, Arithmetic::precise) > 20);
    CHECK(check_identity<Lending, CheckedMesh>({.grid = {5, 4}, .sizes = support::sized<Whole>(400, 30)}, 0, Arithmetic::precise) > 20);
    CHECK(check_identity<Lending, CheckedMesh>({.grid = {6, 5}, .hops = 2, .channel_slots = 3}, 0, Arithmetic::precise) > 20);
}

TEST_CASE("lending: the ledger has its channels and states, and a setup without it has none")
{
    using Plain = Frame<Lossless>;
    static_assert(std::is_same_v<Plain, Sequence<Superstep<Project<Lossless>>, UntilQuiet<Route<Lossless>>, Superstep<Bloom<Lossless>>,
                                                 UntilQuiet<Bloom<Lossless>>, Superstep<DepthSort<Lossless>>,
                                                 Superstep<Composite<Lossless>>>>);
    constexpr auto machine = size_of_machine<Mk2>();
    constexpr auto sizes = LosslessLending::sizes;
    constexpr auto without = SramLedger<Plain>::bytes(machine, sizes), with = SramLedger<Frame<LosslessLending>>::bytes(machine, sizes);
    CHECK(with - without == 8 * (8 + 56 * 32) + 8 * (8 + 12 * 64) + 12 * 160 + 824);
    CHECK(with <= Mk2::sram_bytes);
    CHECK(with + 12 * 136 > Mk2::sram_bytes); // storage takes what is left
    auto const facts = render::setup_for<LosslessLending>();
    CHECK(facts.sram_bytes == with);
    auto const is_channel = [](machine::Region const& r) { return std::string(r.name.text, r.name.size) == "lent splats"; };
    CHECK(std::any_of(facts.ledger.begin(), facts.ledger.end(), is_channel));
}
