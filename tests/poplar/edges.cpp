// test: unoptimised test asan, without tsan
#include "../engine/edges.hpp"
#include "on_poplar.hpp"
#include <standin_vertex.hpp>
#include <tilemesh/poplar/codelet.hpp>

// Channels of all three edges as a Poplar graph. At an edge of the grid, messages come back, are dropped, or arrive at the other end.
using namespace engine_test;
using namespace engine_test::on_edges;

TILEMESH_VERTEX(edges_call_reflecting, Traced<Mk2>, Edges, Call<Edge::reflect>)
TILEMESH_VERTEX(edges_call_dropping, Traced<Mk2>, Edges, Call<Edge::drop>)
TILEMESH_VERTEX(edges_call_wrapping, Traced<Mk2>, Edges, Call<Edge::wrap>)

#define ENTER(Name) POPLAR_STANDIN_VERTEX(Name, reads, keeps, sends, x, y, width, height, step, log_at, task, program)
ENTER(edges_call_reflecting);
ENTER(edges_call_dropping);
ENTER(edges_call_wrapping);

TEST_CASE("poplar: edges reflect, drop and wrap as on a Mesh, on grids of one tile, row and column")
{
    for (Grid grid : edge_grids) {
        CAPTURE(grid.width);
        CAPTURE(grid.height);
        poplar_test::on_both<Edges, Traced<Mk2>>("edges", grid, [](auto& mesh) { load_edges(mesh); }, 2);
        standin::With const restore(standin::settings());
        PoplarMesh graph{Edges{}, grid, Traced<Mk2>{}, poplar_test::options("edges")};
        Mesh mesh{Edges{}, grid, Traced<Mk2>{}};
        load_edges(graph);
        load_edges(mesh);
        graph.run();
        mesh.run();
        check_all_heard(graph);
        CHECK(graph.trace() == mesh.trace());
    }
}
