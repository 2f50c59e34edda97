#include "../engine/programs.hpp"
#include "on_ranks.hpp"

using namespace mpi_test;

namespace {
struct Idle {
    Vote operator()() const noexcept { return Vote::quiet; }
};
/// The other bands that the band of this rank touches.
std::uint64_t neighbours(mpi::Bands const& bands)
{
    auto const first = bands.first(rank()), last = bands.last(rank());
    return first == last ? 0u : (first != 0 ? 1u : 0u) + (last != bands.height() ? 1u : 0u);
}
} // namespace

TEST_CASE("a superstep costs a message to each neighbour, live words only, and one agreement")
{
    Grid const grid{6, 11};
    Bounce bounce;
    MpiMesh<Bounce, Roomy> mesh{MPI_COMM_WORLD, bounce, grid};
    for (auto [tile, ball] : mesh.states<Ball>()) ball.throws = tile.y() == 5 && tile.x() == 0 ? 9 : 0;
    (void)traffic();
    auto const run = mesh.run();
    CHECK(run.messages() == 9);
    auto const eastwards = traffic(); // nothing leaves a row: messages of one word, which says that no end has mail
    std::uint64_t const supersteps = run.steps.at(0).passes + run.steps.at(1).passes;
    CHECK(eastwards.agreements == supersteps);
    CHECK(eastwards.messages == supersteps * neighbours(mesh.bands()));
    CHECK(eastwards.words == eastwards.messages);

    MpiMesh<Heat, Roomy> heat{MPI_COMM_WORLD, Heat{{7}}, grid};
    (void)traffic();
    heat.run();
    auto const full = traffic(); // every tile of a row at an edge sends a float: column, size, note, float
    CHECK(full.agreements == 7);
    CHECK(full.messages == 7 * neighbours(heat.bands()));
    CHECK(full.words == full.messages * (1 + 4 * grid.width));
}

TEST_CASE("a kernel that does not send costs an agreement, a step that no tile needs nothing")
{
    MpiMesh<Sequence<Repeat<Idle>, UntilQuiet<Idle>, UntilQuiet<Catch>>, Roomy> mesh{MPI_COMM_WORLD, {{3}, {}, {}}, Grid{4, 9}};
    (void)traffic();
    auto const run = mesh.run();
    CHECK(run.steps.at(0).passes == 3);
    CHECK(run.steps.at(1).passes == 0);
    CHECK(run.steps.at(2).passes == 0);
    auto const cost = traffic();
    CHECK(cost.agreements == 3);
    CHECK(cost.messages == 0);
}
