#include "../engine/sides.hpp"
#include "on_ranks.hpp"

using namespace mpi_test;
using namespace engine_test::on_edges;

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

TEST_CASE("channels of some sides: rows go to another rank where the channel has that side")
{
    using Up = Some<tilemesh::Edge::wrap, tilemesh::Sides::north>;
    using Down = Some<tilemesh::Edge::reflect, tilemesh::Sides::south | tilemesh::Sides::west>;
    for (auto grid : edge_grids) {
        on_ranks<Up>(grid, [](auto& mesh) { load_some<tilemesh::Edge::wrap, tilemesh::Sides::north>(mesh); }, 2);
        on_ranks<Down>(grid, [](auto& mesh) { load_some<tilemesh::Edge::reflect, tilemesh::Sides::south | tilemesh::Sides::west>(mesh); });
    }
    on_ranks<Cannon<false>>({cannon_side, cannon_side}, [](auto& mesh) { load_cannon(mesh); }, 1, cannon<false>());
    check_trace(cannon<false>(), Grid{cannon_side, cannon_side}, [](auto& mesh) { load_cannon(mesh); });
}
