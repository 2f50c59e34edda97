// test: unoptimised test asan, without tsan
#include "support.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/splat/topologies.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;

// A tile is 8 x 8 pixels. A ball in its middle touches no other tile, so only routing moves records.
namespace {
constexpr std::uint32_t tile_px = 8;

template <class S>
using RouteOnly = Sequence<Superstep<Project<S>>, UntilQuiet<Route<S>>>;

template <class Rule, class Base = support::Room<>>
struct By : Base {
    static constexpr char const* name = "other links";
    using Routing = Rule;
};
using OnTorus = By<Torus>;
template <std::uint32_t Distance>
using OnExpress = By<ExpressLinks<Distance>>;
struct TorusAgain : OnTorus {
    using Addressing = Recomputed;
};
using support::sized;

std::uint32_t distance(std::uint32_t a, std::uint32_t b)
{
    return a > b ? a - b : b - a;
}
/// The fewest steps from a to b among n tiles of a ring.
std::uint32_t steps(Torus, std::uint32_t a, std::uint32_t b, std::uint32_t n)
{
    return std::min(distance(a, b), n - distance(a, b));
}
/// Steps of 1 and, from a multiple of D to the next one, of D, that never pass b.
template <std::uint32_t D>
std::uint32_t steps(ExpressLinks<D>, std::uint32_t a, std::uint32_t b, std::uint32_t)
{
    auto const low = std::min(a, b), high = std::max(a, b);
    auto const first = (low + D - 1) / D * D, last = high / D * D;
    return last <= first ? high - low : (first - low) + (last - first) / D + (high - last);
}

template <class S>
std::vector<std::uint32_t> ids_on(auto& mesh, std::uint32_t& away)
{
    std::vector<std::uint32_t> ids;
    away = 0;
    auto const& frame = mesh.template broadcast<FrameParameters>();
    for (TileId const t : mesh.grid().tiles()) {
        for (auto const& g : mesh.template state<Storage<S>>(t)) {
            ids.push_back(static_cast<std::uint32_t>(g.id));
            away += project(g, frame.view, frame.tiling).anchor == t ? 0 : 1;
        }
        for_each_fifo<S>([&]<class Fifo>(machine::Tag<Fifo>) {
            for (auto const& m : mesh.template state<Fifo>(t)) ids.push_back(static_cast<std::uint32_t>(S::Addressing::record(m).id));
        });
        for (Direction d : news) {
            for (auto const& m : mesh.template incoming<Road<S>>(t, d))
                ids.push_back(static_cast<std::uint32_t>(S::Addressing::record(m).id));
            if constexpr (express_distance<typename S::Routing> != 1)
                for (auto const& m : mesh.template incoming<Express<S>>(t, d))
                    ids.push_back(static_cast<std::uint32_t>(S::Addressing::record(m).id));
        }
    }
    std::sort(ids.begin(), ids.end());
    return ids;
}

/// Routes records from tile to tile, and checks after every superstep that every id is there exactly once.
template <class S, template <class, class> class Engine = Mesh>
struct Job {
    Engine<RouteOnly<S>, AnyMachine> mesh;
    std::vector<std::uint32_t> ids;
    std::uint64_t exchanges = 0, hops = 0;
    std::uint32_t bad_supersteps = 0;

    /// A run that is stuck ends.
    static auto options()
    {
        typename Engine<RouteOnly<S>, AnyMachine>::Options options;
        options.most_passes = 20'000;
        return options;
    }
    Job(Grid grid, Sizes const& sizes) : mesh({}, grid, mesh_sizes<RouteOnly<S>>(size_of_machine<typename S::Machine>(), sizes), options())
    {
        mesh.template broadcast<FrameParameters>() = {
            make_view(support::flat_camera(grid.width * tile_px, grid.height * tile_px), Rules{}),
            make_tiling(grid.width * tile_px, grid.height * tile_px, tile_px, tile_px), 1, 0, 0};
        mesh.observe([this](SuperstepEvent const&) {
            std::uint32_t away = 0;
            if (ids_on<S>(mesh, away) != ids) ++bad_supersteps;
        });
    }
    void put(std::uint32_t id, TileId from, TileId to)
    {
        REQUIRE(support::put<S>(mesh, from,
                                support::ball(id, static_cast<float>(to.x() * tile_px) + 4, static_cast<float>(to.y() * tile_px) + 4)));
        ids.push_back(id);
    }
    /// The number of records that are not on their anchor tile at the end, or are nowhere.
    std::uint32_t run()
    {
        std::sort(ids.begin(), ids.end());
        exchanges = mesh.run().steps[1].exchanges;
        std::uint32_t away = 0;
        auto const now = ids_on<S>(mesh, away);
        for (TileId const t : mesh.grid().tiles()) hops += mesh.template state<Counts>(t).hops;
        return away + (now == ids ? 0 : 1);
    }
};

template <class S>
void check_every_way(Grid grid)
{
    for (TileId const a : grid.tiles())
        for (TileId const b : grid.tiles()) {
            Job<S> job(grid, sized<S>(1, 4));
            job.put(1, a, b);
            CHECK(job.run() == 0);
            CHECK(job.bad_supersteps == 0);
            typename S::Routing const rule;
            CHECK(job.exchanges == steps(rule, a.x(), b.x(), grid.width) + steps(rule, a.y(), b.y(), grid.height));
        }
}
template <class S>
void check_every_pair(Grid grid)
{
    auto const n = grid.size();
    for (std::uint32_t code = 0; code < n * n * n * n; ++code) {
        Job<S, CheckedMesh> job(grid, sized<S>(1, 4)); // the checked engine, which also runs every quiet tile
        job.put(1, grid.tile(code % n), grid.tile(code / n % n));
        job.put(2, grid.tile(code / n / n % n), grid.tile(code / n / n / n));
        if (job.run() != 0 || job.bad_supersteps != 0) FAIL("code ", code, " on ", grid.width, "x", grid.height);
    }
}
template <class S>
void check_crowds(Grid grid, Sizes const& sizes)
{
    for (std::uint32_t kind = 0; kind < 6; ++kind)
        for (std::uint32_t per_tile : {1u, 7u}) {
            Job<S> job(grid, sizes);
            support::Random random(kind * 10 + per_tile);
            std::uint32_t id = 0;
            for (TileId const here : grid.tiles())
                for (std::uint32_t k = 0; k < per_tile; ++k) {
                    auto const x = random.below(grid.width), y = random.below(grid.height);
                    job.put(++id, here,
                            kind == 0   ? TileId::at(3, 2)
                            : kind == 1 ? TileId::at(grid.width - 1, grid.height - 1)
                            : kind == 2 ? TileId::at(grid.width - 1 - here.x(), grid.height - 1 - here.y())
                            // Half a ring away, all in one direction: without lanes, FIFOs of a ring would wait for each other.
                            : kind == 3 ? TileId::at((here.x() + grid.width / 2) % grid.width, here.y())
                            : kind == 4 ? TileId::at((here.x() + grid.width / 2) % grid.width, (here.y() + grid.height / 2) % grid.height)
                                        : TileId::at(x, y));
                }
            CHECK(job.run() == 0);
            CHECK(job.bad_supersteps == 0);
        }
    Job<S> packed(grid, sizes); // all records start on one tile
    for (std::uint32_t id = 1; id <= 200; ++id) packed.put(id, TileId::at(2, 2), grid.tile(id % grid.size()));
    CHECK(packed.run() == 0);
    CHECK(packed.bad_supersteps == 0);
}
} // namespace

TEST_CASE("topologies: from every tile to every tile, one record takes the fewest steps of its links")
{
    check_every_way<OnTorus>({5, 4});
    check_every_way<OnTorus>({2, 3});
    check_every_way<OnExpress<2>>({6, 3});
    check_every_way<OnExpress<4>>({9, 2});
    check_every_way<OnExpress<4>>({1, 10});
}

TEST_CASE("topologies: every pair of records arrives through channels and FIFOs of one, on the checked engine")
{
    for (auto const& grid : {Grid{1, 1}, Grid{2, 1}, Grid{3, 1}, Grid{2, 2}, Grid{1, 4}, Grid{3, 2}}) {
        check_every_pair<OnTorus>(grid);
        check_every_pair<OnExpress<2>>(grid);
    }
}

TEST_CASE("topologies: crowds, and records that chase each other around rings: nothing lost, nothing stuck, with 1, 2, 5 and 8 slots")
{
    for (std::uint32_t slots : {1u, 2u, 5u, 8u}) {
        check_crowds<OnTorus>({6, 5}, sized<OnTorus>(slots, 400));
        check_crowds<TorusAgain>({6, 5}, sized<TorusAgain>(slots, 400));
        check_crowds<OnExpress<2>>({7, 5}, sized<OnExpress<2>>(slots, 400));
        check_crowds<OnExpress<4>>({9, 5}, sized<OnExpress<4>>(slots, 400));
    }
    check_crowds<OnTorus>({6, 5}, sized<OnTorus>(5, 400, 1)); // FIFOs smaller than channels
    check_crowds<OnExpress<2>>({7, 5}, sized<OnExpress<2>>(5, 400, 1));
    check_crowds<OnTorus>({6, 5}, sized<OnTorus>(1, 400, 9)); // and larger
    check_crowds<OnExpress<2>>({7, 5}, sized<OnExpress<2>>(1, 400, 9));
}

TEST_CASE("topologies: where an express link has no room, a record walks")
{
    Grid const grid{9, 1};
    Job<OnExpress<4>> job(grid, sized<OnExpress<4>>(1, 8));
    job.put(1, TileId::at(0, 0), TileId::at(4, 0));
    job.put(2, TileId::at(0, 0), TileId::at(4, 0));
    CHECK(job.run() == 0);
    CHECK(job.hops == 1 + 4);
    CHECK(job.exchanges == 4); // both begin in the first superstep
    Job<OnExpress<4>> roomy(grid, sized<OnExpress<4>>(2, 8));
    roomy.put(1, TileId::at(0, 0), TileId::at(4, 0));
    roomy.put(2, TileId::at(0, 0), TileId::at(4, 0));
    CHECK(roomy.run() == 0);
    CHECK(roomy.hops == 2);
    CHECK(roomy.exchanges == 1);
}

TEST_CASE("topologies: a record meets fewer tiles, and only the rule's channels and FIFOs are in a program")
{
    Grid const grid{40, 36};
    auto const exchanges = [&](auto tag) {
        using S = typename decltype(tag)::type;
        Job<S> job(grid, sized<S>(8, 8));
        job.put(1, TileId::at(0, 0), TileId::at(39, 35));
        CHECK(job.run() == 0);
        CHECK(job.exchanges == job.hops);
        return job.exchanges;
    };
    CHECK(exchanges(machine::Tag<OnTorus>{}) == 1 + 1);
    CHECK(exchanges(machine::Tag<OnExpress<4>>{}) == (9 + 3) + (8 + 3));
    CHECK(exchanges(machine::Tag<OnExpress<8>>{}) == (4 + 7) + (4 + 3));
    Job<OnTorus> far(grid, sized<OnTorus>(8, 8));
    far.put(1, TileId::at(0, 0), TileId::at(20, 18));
    CHECK(far.run() == 0);
    CHECK(far.exchanges == 20 + 18);
    // 0 of the parts of other rules. A channel end has 8 bytes and 64 for each message, a FIFO likewise.
    using Needs = machine::Needs<RouteOnly<OnTorus>>;
    static_assert(!machine::contains<Express<OnTorus>, Needs::Links> && machine::contains<Waiting<OnTorus, 7>, Needs::States>);
    static_assert(!machine::contains<Waiting<support::Room<>, 2>, machine::Needs<RouteOnly<support::Room<>>>::States>);
    constexpr auto bytes = [](auto tag) {
        using S = typename decltype(tag)::type;
        return SramLedger<RouteOnly<S>>::bytes(size_of_machine<Mk2>(), Lossless::sizes);
    };
    constexpr std::uint64_t list = 8 + 200 * 64;
    CHECK(bytes(machine::Tag<OnTorus>{}) == bytes(machine::Tag<support::Room<>>{}) + 6 * list + sizeof(LaneFlow));
    CHECK(bytes(machine::Tag<OnExpress<4>>{}) == bytes(machine::Tag<OnTorus>{}) + 8 * list);
}

namespace {
template <class Rule>
struct Pictured : WithLinks<Lossless, Rule> {
    static constexpr char const* name = "lossless, other links";
};
static_assert(Pictured<Torus>::sizes.road == 124 && Pictured<ExpressLinks<4>>::sizes.waiting == 83);
static_assert(fits<Mk2, Frame<Pictured<Torus>>, Pictured<Torus>> && fits<Mk2, Frame<Pictured<ExpressLinks<4>>>, Pictured<ExpressLinks<4>>>);

/// The frames of a cold start, a step, a turn and a static view.
template <class S, template <class, class> class Engine>
std::vector<RenderedFrame> frames(RendererOptions const& options)
{
    BasicRenderer<S, Engine> renderer(support::map_of(support::cloud(160, 3)), options);
    std::vector<RenderedFrame> out;
    for (float const turn : {0.0f, 0.02f, 0.6f, 0.6f}) out.push_back(renderer.render(support::lens(72, 40, turn)));
    return out;
}
RendererOptions small(std::uint32_t slots, std::uint32_t hops = 0)
{
    RendererOptions options{.grid = {9, 5}};
    options.channel_slots = options.waiting_slots = slots;
    options.hops = hops;
    options.most_passes = 20'000;
    return options;
}
template <class S, template <class, class> class Engine>
void check_pictures(std::vector<RenderedFrame> const& mesh, std::uint32_t slots)
{
    CHECK(BasicRenderer<S, Engine>(support::map_of({})).facts().sram_bytes == BasicRenderer<S, Engine>::Layout::bytes);
    auto const all = frames<S, Engine>(small(slots));
    for (std::size_t i = 0; i < mesh.size(); ++i) {
        CHECK(all[i].report.lost.empty());
        CHECK(support::differing_pixels(all[i].image, mesh[i].image) == 0);
        CHECK(all[i].report.gaussians.visible == mesh[i].report.gaussians.visible);
        CHECK(all[i].report.gaussians.parked == mesh[i].report.gaussians.parked);
        CHECK(all[i].report.gaussians.moved == mesh[i].report.gaussians.moved);
        CHECK(all[i].report.hops <= mesh[i].report.hops);
    }
    CHECK(all[0].report.hops < mesh[0].report.hops);
}
} // namespace

TEST_CASE("topologies: pictures have the bits of the mesh, by value and by reference, on both engines")
{
    auto const mesh = frames<Lossless, Mesh>(small(0));
    CHECK(mesh[0].report.lost.empty());
    for (std::uint32_t slots : {1u, 2u, 8u}) {
        check_pictures<Referenced<Pictured<Torus>>, Mesh>(mesh, slots);
        check_pictures<Referenced<Pictured<ExpressLinks<4>>>, Mesh>(mesh, slots);
        check_pictures<Pictured<ExpressLinks<4>>, CheckedMesh>(mesh, slots);
        check_pictures<Pictured<Torus>, CheckedMesh>(mesh, slots);
    }
}

TEST_CASE("topologies: a bound on hops leaves records under way, which the report lists, and a static view converges")
{
    auto const mesh = frames<Lossless, Mesh>(small(0));
    auto const check = [&](auto tag) {
        using S = typename decltype(tag)::type;
        for (std::uint32_t slots : {1u, 8u}) {
            BasicRenderer<S, Mesh> renderer(support::map_of(support::cloud(160, 3)), small(slots, 2));
            // Views that change on the way: records under way turn back.
            std::uint64_t late = 0;
            for (float const turn : {0.0f, 0.6f, 0.0f, 0.3f, 0.6f}) late += renderer.render(support::lens(72, 40, turn)).report.lost.size();
            CHECK(late != 0);
            auto last = renderer.render(support::lens(72, 40, 0.6f));
            for (int i = 0; i < 400 && !last.report.lost.empty(); ++i) last = renderer.render(support::lens(72, 40, 0.6f));
            CHECK(last.report.lost.empty());
            CHECK(support::differing_pixels(last.image, mesh[3].image) == 0);
        }
    };
    check(machine::Tag<Referenced<Pictured<Torus>>>{});
    check(machine::Tag<Referenced<Pictured<ExpressLinks<4>>>>{});
}
