// test: unoptimised asan, without tsan
#include "support.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/render/host_form.hpp>

using namespace tilemesh;
using namespace tilemesh::splat;

// A tile is 8 x 8 pixels. A ball in its middle touches no other tile, so only routing moves records.
namespace {
constexpr std::uint32_t tile_px = 8;

template <class S>
using RouteOnly = Sequence<Superstep<Project<S>>, UntilQuiet<Route<S>>>;

using S = support::Room<>;
struct Again : S {
    using Addressing = Recomputed;
};
using Dropping = support::Room<Paper>;
using support::sized;

Gaussian at_tile(std::uint32_t id, TileId t)
{
    return support::ball(id, static_cast<float>(t.x() * tile_px) + 4, static_cast<float>(t.y() * tile_px) + 4);
}

/// Routes `records` from their tiles, and checks after every superstep that every id is owned exactly once.
template <class S, template <class, class> class Engine = Mesh>
struct Job {
    Engine<RouteOnly<S>, AnyMachine> mesh;
    std::vector<std::uint32_t> ids;
    std::uint64_t supersteps = 0, refused_storage = 0;
    std::uint32_t bad_supersteps = 0;

    Job(Grid grid, Sizes const& sizes) : mesh({}, grid, mesh_sizes<RouteOnly<S>>(size_of_machine<typename S::Machine>(), sizes))
    {
        mesh.template broadcast<FrameParameters>() = {
            make_view(support::flat_camera(grid.width * tile_px, grid.height * tile_px), Rules{}),
            make_tiling(grid.width * tile_px, grid.height * tile_px, tile_px, tile_px), 1, 0, 0};
        mesh.observe([this](SuperstepEvent const&) {
            std::uint64_t gone = 0;
            for (std::uint32_t i = 0; i < mesh.grid().size(); ++i)
                gone += mesh.template state<Counts>(mesh.grid().tile(i)).storage_full;
            auto const now = support::owned_ids<S>(mesh);
            bool const distinct = std::adjacent_find(now.begin(), now.end()) == now.end();
            if (!distinct || now.size() + gone != ids.size() || (gone == 0 && now != ids)) ++bad_supersteps;
            refused_storage = gone;
        });
    }
    void put(std::uint32_t id, TileId from, TileId to)
    {
        REQUIRE(support::put<S>(mesh, from, at_tile(id, to)));
        ids.push_back(id);
    }
    std::uint32_t on(std::uint32_t x, std::uint32_t y) { return mesh.template state<Storage<S>>(TileId::at(x, y)).size(); }
    /// The number of records that are not on their anchor tile at the end.
    std::uint32_t run()
    {
        std::sort(ids.begin(), ids.end());
        auto const run = mesh.run();
        supersteps = run.steps[1].exchanges;
        std::uint32_t away = 0, home = 0;
        auto const grid = mesh.grid();
        auto const& frame = mesh.template broadcast<FrameParameters>();
        for (std::uint32_t i = 0; i < grid.size(); ++i)
            for (auto const& g : mesh.template state<Storage<S>>(grid.tile(i)))
                ++(project(g, frame.view, frame.tiling).anchor == grid.tile(i) ? home : away);
        return away + static_cast<std::uint32_t>(ids.size() - refused_storage - home);
    }
};
} // namespace

TEST_CASE("routing: from every tile to every tile, one record takes |dx| + |dy| exchanges")
{
    Grid const grid{4, 3};
    for (std::uint32_t i = 0; i < grid.size(); ++i)
        for (std::uint32_t j = 0; j < grid.size(); ++j) {
            Job<S> job(grid, sized<S>(1, 4));
            auto const a = grid.tile(i), b = grid.tile(j);
            job.put(1, a, b);
            CHECK(job.run() == 0);
            CHECK(job.bad_supersteps == 0);
            CHECK(job.supersteps == (a.x() > b.x() ? a.x() - b.x() : b.x() - a.x()) + (a.y() > b.y() ? a.y() - b.y() : b.y() - a.y()));
        }
}

TEST_CASE("routing: on every small grid, every pair of records arrives through channels and FIFOs of one")
{
    for (auto const& grid : {Grid{1, 1}, Grid{2, 1}, Grid{1, 2}, Grid{2, 2}, Grid{3, 2}}) {
        auto const n = grid.size();
        for (std::uint32_t code = 0; code < n * n * n * n; ++code) {
            Job<S, CheckedMesh> job(grid, sized<S>(1, 4)); // the checked engine, which also runs every quiet tile
            job.put(1, grid.tile(code % n), grid.tile(code / n % n));
            job.put(2, grid.tile(code / n / n % n), grid.tile(code / n / n / n));
            if (job.run() != 0 || job.bad_supersteps != 0) FAIL("code ", code, " on ", grid.width, "x", grid.height);
        }
    }
}

TEST_CASE("routing: all to one, one to all, reversal and random, channels of 1, 2 and 5: nothing lost, nothing stuck")
{
    Grid const grid{6, 5};
    auto const check = [&](Sizes const& sizes) {
        for (int kind = 0; kind < 6; ++kind)
            for (std::uint32_t per_tile : {1u, 7u}) {
                Job<S> job(grid, sizes);
                support::Random random(static_cast<std::uint64_t>(kind) * 10 + per_tile);
                std::uint32_t id = 0;
                for (std::uint32_t i = 0; i < grid.size(); ++i)
                    for (std::uint32_t k = 0; k < per_tile; ++k) {
                        auto const here = grid.tile(i);
                        auto const x = random.below(6), y = random.below(5);
                        TileId const to = kind == 0   ? TileId::at(3, 2)
                                          : kind == 1 ? TileId::at(5, 4)
                                          : kind == 2 ? TileId::at(5 - here.x(), 4 - here.y())
                                          : kind == 3 ? TileId::at(here.y(), 4 - std::min(here.x(), 4u))
                                          : kind == 4 ? TileId::at(0, here.y() % 2 == 0 ? 4 : 0)
                                                      : TileId::at(x, y);
                        job.put(++id, here, to);
                    }
                CHECK(job.run() == 0);
                CHECK(job.bad_supersteps == 0);
                CHECK(job.refused_storage == 0);
            }
        Job<S> packed(grid, sizes); // all records start on one tile
        for (std::uint32_t id = 1; id <= 200; ++id) packed.put(id, TileId::at(2, 2), grid.tile(id % grid.size()));
        CHECK(packed.run() == 0);
        CHECK(packed.bad_supersteps == 0);
    };
    check(sized<S>(1, 400));
    check(sized<S>(2, 400));
    check(sized<S>(5, 400));
    check(sized<S>(5, 400, 1)); // FIFOs smaller than channels
    check(sized<S>(1, 400, 9)); // and larger
}

TEST_CASE("routing: within W + H - 2 exchanges from any placement when no channel fills")
{
    Grid const grid{9, 7};
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        Job<S> job(grid, sized<S>(400, 1200));
        support::Random random(seed);
        for (std::uint32_t id = 1; id <= 600; ++id) {
            auto const from = random.below(grid.size()), to = random.below(grid.size());
            job.put(id, grid.tile(from), grid.tile(to));
        }
        job.put(601, TileId::at(0, 0), TileId::at(8, 6)); // corner to corner: the bound is reached
        CHECK(job.run() == 0);
        CHECK(job.supersteps == grid.width + grid.height - 2);
    }
    Job<S> paper(Grid{40, 36}, sized<S>(400, 1200)); // the paper's grid: 74, not max(W, H) = 40
    paper.put(1, TileId::at(0, 0), TileId::at(39, 35));
    CHECK(paper.run() == 0);
    CHECK(paper.supersteps == 74);
}

TEST_CASE("routing: a full storage refuses arrivals, counts them, and blocks no other record")
{
    Grid const grid{5, 1};
    Job<S> job(grid, sized<S>(2, 10));
    for (std::uint32_t id = 1; id <= 10; ++id) job.put(id, TileId::at(2, 0), TileId::at(2, 0)); // full to the last slot
    for (std::uint32_t id = 11; id <= 14; ++id) job.put(id, TileId::at(0, 0), TileId::at(2, 0));
    job.put(15, TileId::at(0, 0), TileId::at(4, 0)); // must pass the full tile
    (void)job.run();
    CHECK(job.bad_supersteps == 0);
    CHECK(job.refused_storage == 4);
    auto const ids = support::owned_ids<S>(job.mesh);
    CHECK(ids.size() == 11);
    CHECK(ids.back() == 15);
    CHECK(job.on(4, 0) == 1);
}

TEST_CASE("routing: n - 1, n and n + 1 records for a storage of n")
{
    for (std::uint32_t n : {5u, 6u, 7u}) {
        Job<S> job(Grid{3, 1}, sized<S>(3, 6));
        for (std::uint32_t id = 1; id <= n; ++id) job.put(id, TileId::at(id % 2 == 0 ? 0 : 2, 0), TileId::at(1, 0));
        (void)job.run();
        CHECK(job.refused_storage == (n > 6 ? n - 6 : 0));
        CHECK(job.on(1, 0) == std::min(n, 6u));
        CHECK(job.bad_supersteps == 0);
    }
}

TEST_CASE("credits: at capacity 1 a sender never sends more than the next FIFO can hold, for any traffic ahead")
{
    // Two rows of traffic that must turn into one full column: the FIFOs fill, and every superstep stays within credit. The engine reports
    // a push into a full FIFO as an error; this test also observes the fill.
    Grid const grid{7, 7};
    Job<S> job(grid, sized<S>(1, 200, 1));
    std::uint32_t id = 0;
    for (std::uint32_t x = 0; x < 7; ++x)
        for (std::uint32_t y = 0; y < 7; ++y)
            for (int k = 0; k < 3; ++k) job.put(++id, TileId::at(x, y), TileId::at(3, y < 3 ? 6 : 0));
    CHECK(job.run() == 0);
    CHECK(job.bad_supersteps == 0);
    std::uint64_t no_credit = 0;
    for (std::uint32_t i = 0; i < grid.size(); ++i) no_credit += job.mesh.state<Counts>(grid.tile(i)).no_credit;
    CHECK(no_credit > 0); // the credits held the senders back
}

TEST_CASE("counters: leaving records that wait count once a pass, by the cause on their own side")
{
    // Five records leave to the east and five to the south, through channels of three. A FIFO of one gives credit for one record in every
    // second pass: 4 + 4 + 3 + 3 + 2 + 2 + 1 + 1 refusals.
    Job<S> job({2, 2}, sized<S>(3, 20, 1));
    auto const from = TileId::at(0, 0);
    for (std::uint32_t id = 1; id <= 10; ++id) job.put(id, from, id % 2 == 0 ? TileId::at(1, 0) : TileId::at(0, 1));
    job.mesh.run();
    CHECK(job.bad_supersteps == 0);
    auto const& counts = job.mesh.state<Counts>(from);
    CHECK(counts.no_credit == 20);
    CHECK(counts.channel_full == 2);
    CHECK(job.on(1, 0) == 5);
    CHECK(job.on(0, 1) == 5);
    CHECK(job.mesh.state<FlowControl>(from).leaving == 0);
}

TEST_CASE("drop: a record that meets a full channel takes a slot where it is; only a full storage loses it")
{
    Grid const grid{5, 5};
    for (std::uint32_t const records : {30u, 3u}) {
        Job<Dropping> job(grid, sized<Dropping>(1, records));
        for (std::uint32_t i = 0; i < grid.size(); ++i) job.put(i + 1, grid.tile(i), TileId::at(2, 2));
        auto const away = job.run();
        CHECK(job.bad_supersteps == 0); // lost records are counted, and every other id is owned once
        CHECK((job.refused_storage == 0) == (records == 30));
        if (records == 30) CHECK(away == 0);
    }
}

TEST_CASE("carried and recomputed addresses route alike")
{
    Grid const grid{6, 6};
    Job<S> carried(grid, sized<S>(3, 300));
    Job<Again> again(grid, sized<S>(3, 300));
    support::Random random(77);
    for (std::uint32_t id = 1; id <= 300; ++id) {
        auto const from = grid.tile(random.below(36)), to = grid.tile(random.below(36));
        carried.put(id, from, to);
        again.put(id, from, to);
    }
    CHECK(carried.run() == 0);
    CHECK(again.run() == 0);
    CHECK(carried.supersteps == again.supersteps);
    for (std::uint32_t i = 0; i < grid.size(); ++i) {
        auto const a = carried.mesh.state<Storage<S>>(grid.tile(i));
        auto const b = again.mesh.state<Storage<Again>>(grid.tile(i));
        REQUIRE(a.size() == b.size());
        for (std::uint32_t k = 0; k < a.size(); ++k) CHECK(a[k].id == b[k].id);
    }
}

TEST_CASE("parked: a record with nothing on screen stays where it is; an off-screen mean with pixels on screen goes to the edge tile")
{
    Grid const grid{4, 4};
    Job<S> job(grid, sized<S>(4, 10));
    job.ids = {1, 2, 3, 4};
    auto behind = at_tile(1, TileId::at(0, 0));
    behind.mean_world[2] = -1;
    auto faint = at_tile(2, TileId::at(3, 3));
    faint.opacity = 1.0f / 256;
    REQUIRE(support::put<S>(job.mesh, TileId::at(1, 1), behind));
    REQUIRE(support::put<S>(job.mesh, TileId::at(1, 2), faint));
    REQUIRE(support::put<S>(job.mesh, TileId::at(2, 2), support::ball(3, 1e6f, 10)));
    REQUIRE(support::put<S>(job.mesh, TileId::at(0, 0), support::ball(4, 36, 12, 4))); // 4 pixels right of the frame, reaches in
    job.mesh.run();
    CHECK(job.bad_supersteps == 0);
    CHECK(job.on(1, 1) == 1);
    CHECK(job.on(1, 2) == 1);
    CHECK(job.on(2, 2) == 1);
    auto const edge = job.mesh.state<Storage<S>>(TileId::at(3, 1));
    REQUIRE(edge.size() == 1);
    CHECK(edge[0].id == GaussianId{4});
}

TEST_CASE("lookup: rows of a table are found among any number of records, before and after a set of them answers")
{
    struct Marks {
        std::uint32_t n;
        std::uint32_t size() const { return n; }
    };
    for (std::uint32_t n : {0u, 1u, 127u, 128u, 1000u}) {
        CAPTURE(n);
        std::vector<SplatRow> rows;
        for (std::uint32_t i = 0; i < n; ++i) rows.push_back({7 * i});
        Access<TableParameters>::Lookup lookup;
        Here const here{TileId::at(0, 0), Grid{1, 1}};
        TableParameters const frame{};
        bool right = true;
        for (std::uint32_t k = 0; k < 60; ++k) {
            auto const have = static_cast<std::uint32_t>(rows.size());
            std::uint32_t const row = 7 * (k * 37 % 1100); // now and then one of the table
            auto const at = lookup.slot_of(here, frame, Marks{have}, rows.data(), Reference{GaussianId{k}, row});
            auto const is = std::find_if(rows.begin(), rows.end(), [&](SplatRow s) { return s.row == row; });
            right = right && at == (is == rows.end() ? no_slot : static_cast<std::uint32_t>(is - rows.begin()));
            lookup.add({7 * k + 1}); // a record that comes in the same pass
            rows.push_back({7 * k + 1});
            right = right && lookup.slot_of(here, frame, Marks{have + 1}, rows.data(), Reference{GaussianId{k}, 7 * k + 1}) == have;
        }
        CHECK(right);
    }
}

TEST_CASE("lookup: a record that moved is only on tiles of the span where it was; others need no search")
{
    struct Marks {
        std::uint32_t size() const { return 1; }
    };
    SplatRow const rows[] = {{1}};
    Reference const message{GaussianId{5}, 1};
    TileSpan const spans[] = {TileSpan::all(), {TileId::at(2, 3), TileId::at(4, 3)}};
    std::uint8_t states[] = {0, RowState::visible | RowState::moved};
    TableParameters frame{};
    frame.row_states = HostPointer<std::uint8_t const>(states);
    auto const found = [&](std::uint32_t x, std::uint32_t y) {
        Access<TableParameters>::Lookup lookup;
        return lookup.slot_of({TileId::at(x, y), Grid{8, 8}}, frame, Marks{}, rows, message) == 0;
    };
    CHECK(found(0, 0)); // nothing is known
    frame.before = HostPointer<TileSpan const>(spans);
    for (std::uint32_t y = 0; y < 8; ++y)
        for (std::uint32_t x = 0; x < 8; ++x) CHECK(found(x, y) == (y == 3 && x >= 2 && x <= 4));
    states[1] = RowState::visible; // the span of a record that did not move is an old one
    CHECK(found(0, 0));
    CHECK(TileSpan::all().has(TileId::at(0xffff, 0xffff)));
}
