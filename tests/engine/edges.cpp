// test: unoptimised test asan tsan
#include "sides.hpp"

// Messages over an edge of the grid come back, are dropped, or arrive at the other end. The tests compare words, notes, counters, traces.
using namespace engine_test;
using namespace engine_test::on_edges;

TEST_CASE("edges: every tile reads what a loop without a mesh says, on each engine and on grids of one tile, row and column")
{
    for (Grid grid : edge_grids) {
        CAPTURE(grid.width);
        CAPTURE(grid.height);
        auto const played = everywhere<Edges>(grid, [](auto& mesh) { load_edges(mesh); });
        check_kept<Edge::reflect>(*played.mesh);
        check_kept<Edge::drop>(*played.mesh);
        check_kept<Edge::wrap>(*played.mesh);
        auto const sides = [&](Edge edge) { return 4 * grid.size() - (edge == Edge::drop ? 2 * (grid.width + grid.height) : 0); };
        std::size_t step = 0;
        for (Edge edge : {Edge::reflect, Edge::drop, Edge::wrap}) {
            CAPTURE(step);
            auto const expected = expected_of(grid, edge);
            auto const &first = played.step(step++), &rest = played.step(step++);
            CHECK(first.messages + rest.messages == expected.messages);
            bool const any = expected.messages != 0;
            CHECK(first.exchanges == (any ? 1 : 0));
            CHECK(rest.exchanges == (any ? calls - 1 : 0));
            CHECK(rest.passes == (any ? calls : calls - 1)); // the last pass only reads, if any mail came
            CHECK(first.capacity_bytes == (any ? sides(edge) * (8 + 3 * 4) : 0));
            CHECK(rest.capacity_bytes == (any ? (calls - 1) * sides(edge) * (8 + 3 * 4) : 0));
        }
    }
}

TEST_CASE("edges: what is dropped counts in a peak, because it lay in the outgoing end, and in nothing else")
{
    on_each<Some<Edge::drop>>(Grid{1, 1}, [](auto& mesh) {
        load_some<Edge::drop>(mesh);
        auto const run = mesh.run();
        CHECK(run.messages() == 0);
        CHECK(run.exchanges() == 0);
        CHECK(run.peaks.back().items == 3);
        CHECK(run.steps[0].live_bytes + run.steps[1].live_bytes == 0);
        CHECK(mesh.run().peaks.back().items == 0); // the end is empty in the next run
    });
}

TEST_CASE("edges: a trace holds no dropped bytes, and says which edges the channels of a step have")
{
    Grid const grid{3, 2};
    auto const traced = [&](auto&& mesh) {
        load_edges(mesh);
        mesh.run();
        return mesh.trace();
    };
    auto const checked = traced(CheckedMesh{Edges{}, grid, Traced<Mk2>{}});
    CHECK(checked == traced(Mesh{Edges{}, grid, Traced<Mk2>{}}));
    CHECK(checked == traced(Mesh{Edges{}, grid, Traced<Mk2>{}, {.threads = 3}}));
    for (auto const& s : checked.supersteps) {
        auto const edge = s.step < 2 ? Edge::reflect : s.step < 4 ? Edge::drop : Edge::wrap;
        CHECK(s.edge == edge);
        CHECK(s.capacity_bytes == 8 + 3 * 4);
        for (auto const& t : s.tiles)
            for (Direction d : news) {
                auto const sends = s.sent && (edge != Edge::drop || grid.has_neighbour(grid.tile(t.tile), d));
                CHECK((t.sent_bytes[index(d)] != 0) == sends);
            }
    }
}

TEST_CASE("the states of all tiles as a range: row by row, structs by reference, lists as views, const where the mesh is")
{
    Mesh mesh{Edges{}, Grid{3, 2}};
    std::uint32_t i = 0;
    for (auto [tile, kept] : mesh.states<Kept<Edge::wrap>>()) {
        CHECK(tile == mesh.grid().tile(i));
        kept.sends = ++i;
    }
    CHECK(i == 6);
    CHECK(mesh.state<Kept<Edge::wrap>>(TileId::at(2, 1)).sends == 6);
    std::uint32_t sum = 0;
    for (auto [tile, kept] : std::as_const(mesh).states<Kept<Edge::wrap>>()) {
        static_assert(std::is_const_v<std::remove_reference_t<decltype(kept)>>);
        sum += kept.sends;
    }
    CHECK(sum == 21);
    i = 0;
    for (TileId tile : mesh.grid().tiles()) CHECK(tile == mesh.grid().tile(i++));
    CHECK(i == 6);
}
