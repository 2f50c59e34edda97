// test: unoptimised test asan tsan
#include "../standard.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/model/any_to_any.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/exchange.hpp>
#include <tilemesh/model/trace_files.hpp>

// Channels that skip tiles, beside channels to the neighbours.
using namespace tilemesh;

namespace {

constexpr std::uint32_t hop = 3;
struct Near : Channel<std::uint32_t, 1, Edge::drop> {
    static constexpr char const* name = "near";
};
struct Far : Channel<std::uint32_t, 2, Edge::drop, Sides::all, hop> {
    static constexpr char const* name = "far";
};
struct Heard {
    static constexpr char const* name = "heard";
    std::uint32_t near[4], far[4], notes[4], times;
};
/// Every tile tells all sides its number, twice; the far ones get it two times, with a note.
struct Tell {
    static constexpr char const* name = "tell";
    Vote operator()(Here here, Heard& heard, In<Near> near_in, Out<Near> near, In<Far> far_in, Out<Far> far) const noexcept
    {
        std::uint32_t const me = 1000 + here.grid.index_of(here.tile);
        for (Direction d : news) {
            for (std::uint32_t w : near_in[d]) heard.near[index(d)] += w;
            for (std::uint32_t w : far_in[d]) heard.far[index(d)] += w;
            heard.notes[index(d)] += far_in[d].note();
            if (heard.times == 2) continue;
            near[d].push(me);
            far[d].push(me);
            far[d].push(me + 1);
            far[d].set_note(me);
        }
        return heard.times == 2 ? Vote::quiet : (++heard.times, Vote::busy);
    }
};
using Program = Sequence<Superstep<Tell>, UntilQuiet<Tell>>;
using Machine = Traced<Mk2>;

/// The tile `distance` away, or -1.
int tile_from(Grid grid, TileId t, Direction d, int distance)
{
    int const x = static_cast<int>(t.x()) + (d == Direction::east ? distance : d == Direction::west ? -distance : 0);
    int const y = static_cast<int>(t.y()) + (d == Direction::south ? distance : d == Direction::north ? -distance : 0);
    int const w = static_cast<int>(grid.width), h = static_cast<int>(grid.height);
    return x < 0 || y < 0 || x >= w || y >= h ? -1 : y * w + x;
}
template <class M>
void check_heard(M& mesh)
{
    Grid const grid = mesh.grid();
    for (TileId const t : grid.tiles()) {
        auto const& heard = mesh.template state<Heard>(t);
        for (Direction d : news) {
            int const near = tile_from(grid, t, d, 1), far = tile_from(grid, t, d, hop);
            CHECK(heard.near[index(d)] == (near < 0 ? 0u : 2 * (1000u + static_cast<std::uint32_t>(near))));
            CHECK(heard.far[index(d)] == (far < 0 ? 0u : 2 * (2001u + 2 * static_cast<std::uint32_t>(far))));
            CHECK(heard.notes[index(d)] == (far < 0 ? 0u : 2 * (1000u + static_cast<std::uint32_t>(far))));
        }
    }
}
} // namespace

TEST_CASE("far: a channel that skips tiles reaches the tile at its distance and no other, on each engine, with one trace")
{
    for (Grid const grid : {Grid{7, 5}, Grid{1, 1}, Grid{3, 3}, Grid{1, 9}, Grid{40, 2}}) {
        Mesh<Program, Machine> mesh({}, grid), threads({}, grid, {.threads = 3});
        CheckedMesh<Program, Machine> checked({}, grid);
        auto const run = mesh.run(), also = threads.run(), twin = checked.run();
        check_heard(mesh);
        check_heard(threads);
        check_heard(checked);
        CHECK(mesh.trace() == threads.trace());
        CHECK(mesh.trace() == checked.trace());
        CHECK(run.messages() == twin.messages());
        for (std::size_t i : {0u, 1u}) {
            CHECK(also.steps[i].live_bytes == twin.steps[i].live_bytes);
            CHECK(run.steps[i].capacity_bytes == twin.steps[i].capacity_bytes);
        }
        std::uint64_t near = 0, far = 0; // links
        for (TileId const t : grid.tiles())
            for (Direction d : news) near += tile_from(grid, t, d, 1) < 0 ? 0 : 1, far += tile_from(grid, t, d, hop) < 0 ? 0 : 1;
        CHECK(run.messages() == 2 * near + 4 * far);
        for (auto const& step : run.steps) {
            CHECK(step.exchanges == (near == 0 ? 0 : 1));
            CHECK(step.capacity_bytes == step.exchanges * (near * 12 + far * 16));
        }

        // The model: the tile that receives most gets 12 bytes from each neighbour and 16 over each far link.
        auto model = mk2();
        model.exchange_cost = ExchangeCost::live;
        std::uint64_t most = 0, sent = 0;
        for (TileId const t : grid.tiles()) {
            std::uint64_t bytes = 0;
            for (Direction d : news) bytes += (tile_from(grid, t, d, 1) < 0 ? 0u : 12u) + (tile_from(grid, t, d, hop) < 0 ? 0u : 16u);
            most = std::max(most, bytes);
            sent += bytes;
        }
        auto const exchange = [&](std::uint64_t bytes) {
            return model.exchange_cycles + (bytes * model.exchange_millicycles_a_byte + 999) / 1000;
        };
        if (near != 0) {
            CHECK(model_cost(model, mesh.trace(), grid).supersteps[0].exchange == exchange(most));
            CHECK(model_cost(mk2(), mesh.trace(), grid).supersteps[0].exchange == exchange(4 * (12 + 16))); // whole capacities
        }
        CHECK(any_to_any(model, mesh.trace(), grid).steps[0].sent_bytes == 2 * sent);
        if (far == 0) continue;
        // What asks for sides and neighbours, or for wires of a network, refuses the trace.
        CHECK_THROWS_WITH_AS((void)heat_map(mesh.trace(), model, grid, TileSum::sent_bytes), doctest::Contains("links that skip tiles"),
                             Error);
        model.network = exchange_network(model, grid);
        CHECK_THROWS_WITH_AS((void)model_cost(model, mesh.trace(), grid), doctest::Contains("links that skip tiles"), Error);
    }
}

TEST_CASE("far: its ends cost what a channel's do, and the grid names the tile at a distance")
{
    CHECK(SramLedger<Program>::channel_bytes<Far>(2) == 8 * (8 + 2 * 4));
    constexpr Grid grid{9, 4};
    static_assert(grid.reaches(TileId::at(4, 0), Direction::east, 4) && !grid.reaches(TileId::at(5, 0), Direction::east, 4));
    static_assert(grid.reaches(TileId::at(4, 0), Direction::west, 4) && !grid.reaches(TileId::at(3, 0), Direction::west, 4));
    static_assert(grid.reaches(TileId::at(0, 3), Direction::north, 3) && !grid.reaches(TileId::at(0, 1), Direction::south, 3));
    CHECK(grid.tile_at(TileId::at(4, 0), Direction::south, 3) == TileId::at(4, 3));
}
