// test: unoptimised test asan tsan
#include "sides.hpp"
#include <tilemesh/machine/tile.hpp>

// Channels that have some of the four sides: every engine moves what the same program moves on channels with all sides.
using namespace engine_test;
using namespace engine_test::on_edges;

namespace {

/// Runs the program on every engine, with the sides alone and with all, and checks both against a loop without a mesh.
template <Edge E, Sides S>
void check_some()
{
    for (Grid grid : edge_grids) {
        CAPTURE(grid.width);
        CAPTURE(grid.height);
        auto const load = [](auto& mesh) { load_some<E, S>(mesh); };
        auto const some = everywhere<Some<E, S>>(grid, load);
        auto const full = everywhere<Some<E, S, true>>(grid, load);
        check_kept<E, S>(*some.mesh);
        check_kept<E, S>(*full.mesh);
        auto const messages = expected_of(grid, E, S).messages;
        std::uint64_t moved = 0, all = 0;
        for (std::size_t i = 0; i < 2; ++i) {
            CAPTURE(i);
            auto const &a = some.step(i), &b = full.step(i);
            CHECK(a.passes == b.passes);
            CHECK(a.exchanges == b.exchanges);
            CHECK(a.tile_runs == b.tile_runs);
            CHECK(a.live_bytes == b.live_bytes);
            CHECK(a.messages == b.messages);
            moved += a.messages;
            std::uint64_t lines = 0; // tiles that send to a side that delivers, by the grid's size
            for (auto d : news)
                if (contains(S, d))
                    lines += grid.size() - (E != Edge::drop ? 0u : d == Direction::north || d == Direction::south ? grid.width : grid.height);
            CHECK(a.capacity_bytes == a.exchanges * lines * (8 + 3 * 4));
            all += b.capacity_bytes;
            CHECK((a.capacity_bytes < b.capacity_bytes || b.exchanges == 0));
        }
        CHECK(moved == messages);
        CHECK(some.last().digests == full.last().digests); // ends that are not there are empty ones
        CHECK((all > 0 || messages == 0));
    }
}

} // namespace

TEST_CASE("sides: every tile reads what a loop without a mesh says, on each engine, with fewer bytes exchanged")
{
    check_some<Edge::reflect, Sides::east>();
    check_some<Edge::reflect, Sides::north | Sides::west>();
    check_some<Edge::drop, Sides::south>();
    check_some<Edge::drop, Sides::east | Sides::south>();
    check_some<Edge::wrap, Sides::west>();
    check_some<Edge::wrap, Sides::north | Sides::east | Sides::south>();
}

TEST_CASE("sides: Cannon's product is right, in a quarter of the channels' SRAM and of the bytes exchanged")
{
    Grid const grid{cannon_side, cannon_side};
    auto const load = [](auto& mesh) { load_cannon(mesh); };
    auto const some = everywhere<Cannon<false>>(grid, load, 1, cannon<false>());
    auto const full = everywhere<Cannon<true>>(grid, load, 1, cannon<true>());
    check_cannon(*some.mesh);
    check_cannon(*full.mesh);
    CHECK(words_of(*some.mesh) == words_of(*full.mesh));
    CHECK(some.step(0).messages == full.step(0).messages);
    CHECK(some.step(0).messages == 2 * cannon_side * grid.size());
    CHECK(some.step(0).capacity_bytes == cannon_side * grid.size() * 2 * (8 + 4));
    CHECK(4 * some.step(0).capacity_bytes == full.step(0).capacity_bytes);

    using Some = Tile<Mk2, Cannon<false>>;
    using All = Tile<Mk2, Cannon<true>>;
    CHECK(Some::own_channel_bytes<RowA<false>>() == 2 * (8 + 4)); // an end in, an end out, each with a head
    CHECK(All::own_channel_bytes<RowA<true>>() == 8 * (8 + 4));
    CHECK(All::bytes - Some::bytes == 2 * 6 * (8 + 4));
    CHECK(some.mesh->sram_bytes() == Some::bytes);
    CHECK(std::string(Some::ledger()[0].what) == "channel, 2 ends");
    CHECK(Some::ledger()[0].bytes == 24);
    CHECK(std::string(All::ledger()[0].what) == "channel, 8 ends");
}

TEST_CASE("sides: edges that reflect need an end for what comes back")
{
    using Reflecting = Way<Edge::reflect, Sides::east>;
    using Dropping = Way<Edge::drop, Sides::east>;
    CHECK((Reflecting::receives_from == (Sides::west | Sides::east)));
    CHECK(ends_in<Reflecting> + ends_out<Reflecting> == 2 + 1);
    CHECK((Dropping::receives_from == Sides::west));
    CHECK(ends_in<Dropping> + ends_out<Dropping> == 1 + 1);
    CHECK((opposite(Sides::north | Sides::east) == (Sides::south | Sides::west)));
    using Everywhere = Way<Edge::wrap>;
    CHECK(ends_in<Everywhere> + ends_out<Everywhere> == 4 + 4);
    using Program = Some<Edge::reflect, Sides::east>;
    CHECK(Tile<Mk2, Program>::own_channel_bytes<Reflecting>() == 3 * (8 + 12));
    CHECK(std::string(Tile<Mk2, Program>::ledger()[0].what) == "channel, 3 ends");
}

namespace {
struct Line : Channel<std::uint32_t, dynamic_capacity, Edge::drop, Sides::south> {};
struct Fall {
    void operator()(Kept<Edge::drop, Sides::south>& kept, In<Line> in, Out<Line> out) const noexcept
    {
        for (std::uint32_t v : in.from<Direction::north>()) kept.words[0] += v;
        out.to_all(1 + kept.words[0]);
    }
};
struct Stray { // sends to a side that the channel lacks, on one tile
    static constexpr char const* name = "stray";
    void operator()(Here here, In<Line>, Out<Line> out) const noexcept
    {
        out[Direction::south].push(1);
        if (here.tile == TileId::at(1, 1)) out[Direction::east].push(2);
    }
};
} // namespace

TEST_CASE("sides: a channel without slots yet gets them by limit, and takes SRAM for its ends alone")
{
    on_each<Superstep<Fall>>(Grid{2, 3}, [](auto& mesh) {
        auto const heads = mesh.sram_bytes();
        mesh.template limit<Line>(10);
        CHECK(mesh.sram_bytes() == heads + 2 * 10 * 4);
        for (int i = 0; i < 3; ++i) mesh.run();
        CHECK(mesh.template state<Kept<Edge::drop, Sides::south>>(TileId::at(1, 2)).words[0] == 3); // 1 and 2, from the tile above
        CHECK(mesh.template incoming<Line>(TileId::at(1, 2), Direction::north).size() == 1);
        for (auto d : {Direction::east, Direction::west, Direction::south})
            CHECK(mesh.template incoming<Line>(TileId::at(1, 2), d).empty());
    });
}

TEST_CASE("sides: a message to a side without an end is a broken contract")
{
    on_each<Superstep<Stray>>(Grid{3, 3}, [](auto& mesh) {
        mesh.template limit<Line>(2);
        auto const text = error_of([&] { mesh.run(); });
        CHECK(has(text, "a message to a side that the channel does not have"));
        CHECK(has(text, "tile (1, 1)"));
        CHECK(has(text, "; send to another side"));
    });
}

TEST_CASE("sides: a trace has the bytes of each side")
{
    auto const trace_of = [](auto&& mesh) {
        load_cannon(mesh);
        mesh.run();
        return mesh.trace();
    };
    Grid const grid{cannon_side, cannon_side};
    auto const trace = trace_of(Mesh{cannon<false>(), grid, Traced<Mk2>{}});
    CHECK(trace == trace_of(CheckedMesh{cannon<false>(), grid, Traced<Mk2>{}}));
    CHECK(trace == trace_of(Mesh{cannon<false>(), grid, Traced<Mk2>{}, {.threads = 3}}));
    auto const& s = trace.supersteps.front();
    CHECK(s.capacity_bytes == 2 * (8 + 4));
    CHECK(s.capacity_towards(Direction::west) == 8 + 4);
    CHECK(s.capacity_towards(Direction::north) == 8 + 4);
    CHECK(s.capacity_towards(Direction::east) == 0);
    CHECK(s.capacity_towards(Direction::south) == 0);
    CHECK(s.capacity_of_tile() == 2 * (8 + 4));
    for (auto const& t : s.tiles) {
        CHECK(t.sent_bytes[index(Direction::west)] == 12);
        CHECK(t.sent_bytes[index(Direction::east)] == 0);
    }
}
