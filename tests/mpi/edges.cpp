#include "../engine/edges.hpp"
#include "on_ranks.hpp"
#include <doctest/doctest.h>

using namespace mpi_test;

TEST_CASE("all kinds of edges: what wraps from the first row to the last goes from the first rank to the last")
{
    for (auto grid : edge_grids) {
        CAPTURE(grid.width);
        CAPTURE(grid.height);
        on_ranks<Edges>(grid, [](auto& mesh) { load_edges(mesh); }, 2);
    }
    on_ranks<Edges>({3, 7}, [](auto& mesh) { load_edges(mesh); });
    check_trace(Edges{}, Grid{2, 3}, [](auto& mesh) { load_edges(mesh); });
}
