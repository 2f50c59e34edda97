// test: unoptimised test asan, without tsan
#include "../engine/sides.hpp"
#include "on_poplar.hpp"

// Channels of all three edges, and channels that have some of the four sides, as a Poplar graph: variables, edges of vertices and copies for
// their ends alone. At an edge of the grid, messages come back, are dropped, or arrive at the other end.
using namespace engine_test;
using namespace engine_test::on_edges;

using Reflecting = Some<Edge::reflect, Sides::north | Sides::west>;
using Dropping = Some<Edge::drop, Sides::east>;
VERTEX(edges_send_reflecting, Traced<Mk2>, Edges, Send<Edge::reflect>)
VERTEX(edges_send_dropping, Traced<Mk2>, Edges, Send<Edge::drop>)
VERTEX(edges_send_wrapping, Traced<Mk2>, Edges, Send<Edge::wrap>)
VERTEX(reflecting_send_reflecting, Traced<Mk2>, Reflecting, Send<Edge::reflect, Sides::north | Sides::west>)
VERTEX(dropping_send_dropping, Traced<Mk2>, Dropping, Send<Edge::drop, Sides::east>)
VERTEX(cannon_multiply, Traced<Mk2>, Cannon<false>, Multiply<false>)
VERTEX(cannon_forget, Traced<Mk2>, Cannon<false>, Forget<false>)

TEST_CASE("poplar: edges reflect, drop and wrap as on a Mesh, on grids of one tile, row and column")
{
    for (Grid grid : edge_grids) {
        CAPTURE(grid.width);
        CAPTURE(grid.height);
        poplar_test::on_both<Edges, Traced<Mk2>>("edges", grid, [](auto& mesh) { load_edges(mesh); }, 2);
    }
}

TEST_CASE("poplar: channels of some sides move what a Mesh moves")
{
    for (Grid grid : edge_grids) {
        CAPTURE(grid.width);
        CAPTURE(grid.height);
        poplar_test::on_both<Reflecting, Traced<Mk2>>("reflecting", grid,
            [](auto& mesh) { load_some<Edge::reflect, Sides::north | Sides::west>(mesh); }, 2);
        poplar_test::on_both<Dropping, Traced<Mk2>>("dropping", grid, [](auto& mesh) { load_some<Edge::drop, Sides::east>(mesh); }, 2);
    }
}

TEST_CASE("poplar: Cannon's product on two ends a channel")
{
    PoplarMesh graph{cannon<false>(), Grid{cannon_side, cannon_side}, Traced<Mk2>{}, poplar_test::options("cannon")};
    load_cannon(graph);
    graph.run();
    check_cannon(graph);
    // Two channels with an end in and an end out less three ends each: six spans of a vertex's fields in `multiply`, and of the ends that it
    // reads; and as many heads of mail to forget.
    auto const some = on_poplar::vertex_bytes<Cannon<false>>(), full = on_poplar::vertex_bytes<Cannon<true>>();
    CHECK(full - some == 8 * (2 * (3 + 3) + 2 * 3 + 2 * 3 + 2 * 3)); // multiply; forget's reads, and what it forgets; the start
}
