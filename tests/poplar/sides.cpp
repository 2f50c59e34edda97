// test: unoptimised test asan, without tsan
#include "../engine/sides.hpp"
#include "on_poplar.hpp"
#include <standin_vertex.hpp>
#include <tilemesh/poplar/codelet.hpp>
#include <tilemesh/poplar/ledger.hpp>

// Channels that have some of the four sides as a Poplar graph: variables, edges of vertices and copies for their ends alone.
using namespace engine_test;
using namespace engine_test::on_edges;

using Reflecting = Some<Edge::reflect, Sides::north | Sides::west>;
using Dropping = Some<Edge::drop, Sides::east>;
using Wrapping = Some<Edge::wrap, Sides::north | Sides::east | Sides::south>;
TILEMESH_VERTEX(reflecting_send_some, Traced<Mk2>, Reflecting, SendSome<Edge::reflect, Sides::north | Sides::west, false>)
TILEMESH_VERTEX(dropping_send_some, Traced<Mk2>, Dropping, SendSome<Edge::drop, Sides::east, false>)
TILEMESH_VERTEX(wrapping_send_some, Traced<Mk2>, Wrapping, SendSome<Edge::wrap, Sides::north | Sides::east | Sides::south, false>)
TILEMESH_VERTEX(cannon_multiply, Traced<Mk2>, Cannon<false>, Multiply<false>)
TILEMESH_VERTEX(cannon_forget, Traced<Mk2>, Cannon<false>, Forget<false>)

#define ENTER(Name) POPLAR_STANDIN_VERTEX(Name, reads, keeps, sends, x, y, width, height, step, log_at, task, program)
ENTER(reflecting_send_some);
ENTER(dropping_send_some);
ENTER(wrapping_send_some);
ENTER(cannon_multiply);
ENTER(cannon_forget);

namespace {
template <Edge E, Sides S>
void check_some(char const* prefix)
{
    CAPTURE(prefix);
    for (Grid grid : edge_grids) {
        CAPTURE(grid.width);
        CAPTURE(grid.height);
        poplar_test::on_both<Some<E, S>, Traced<Mk2>>(prefix, grid, [](auto& mesh) { load_some<E, S>(mesh); }, 2);
        standin::With const restore(standin::settings());
        PoplarMesh graph{Some<E, S>{}, grid, Traced<Mk2>{}, poplar_test::options(prefix)};
        Mesh mesh{Some<E, S>{}, grid, Traced<Mk2>{}};
        load_some<E, S>(graph);
        load_some<E, S>(mesh);
        graph.run();
        mesh.run();
        check_kept<E, S>(graph);
        CHECK(graph.trace() == mesh.trace());
    }
}
} // namespace

TEST_CASE("poplar: channels of some sides move what a Mesh moves")
{
    check_some<Edge::reflect, Sides::north | Sides::west>("reflecting");
    check_some<Edge::drop, Sides::east>("dropping");
    check_some<Edge::wrap, Sides::north | Sides::east | Sides::south>("wrapping");
}

TEST_CASE("poplar: Cannon's product on two ends a channel")
{
    Grid const grid{cannon_side, cannon_side};
    standin::With const restore(standin::settings());
    PoplarMesh graph{cannon<false>(), grid, Traced<Mk2>{}, poplar_test::options("cannon")};
    load_cannon(graph);
    graph.run();
    check_cannon(graph);
    // Two channels with an end in and an end out less three ends each: six spans of a vertex's fields in `multiply`, and of the ends that it
    // reads; and as many heads of mail to forget.
    auto const some = on_poplar::vertex_bytes<Cannon<false>>(), full = on_poplar::vertex_bytes<Cannon<true>>();
    CHECK(full - some == 8 * (2 * (3 + 3) + 2 * 3 + 2 * 3 + 2 * 3)); // multiply; forget's reads, and what it forgets; the start
}
