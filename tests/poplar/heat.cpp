// test: unoptimised test asan tsan
#include "../../examples/heat/heat.hpp"
#include "on_poplar.hpp"

// The heat program of examples/heat, from the header that its host program and its codelet include.
using namespace tilemesh;

namespace {
using Heat = Repeat<Diffuse>;
Heat const program{1001};

template <class M>
void warm(M& mesh)
{
    mesh.template broadcast<Conductivity>().per_step = 0.2f;
    for (std::uint32_t i = 0; i < mesh.grid().size(); ++i) mesh.template state<Cell>(mesh.grid().tile(i)).kelvin = 280.0f + static_cast<float>(i % 7);
}
} // namespace

TEST_CASE("poplar: heat on 40 x 36 tiles is the same program, bit for bit")
{
    Grid const grid = engine_test::fast() ? Grid{8, 5} : Grid{40, 36};
    standin::With const restore(standin::settings());
    poplar_test::use(poplar_test::executions[2]);
    Mesh<Heat> mesh{program, grid};
    PoplarMesh<Heat> graph{program, grid, poplar_test::options("heat")};
    warm(mesh);
    warm(graph);
    auto const run = mesh.run();
    CHECK(run.exchanges() == 1001);
    CHECK(run.messages() == 1001u * 4 * grid.size());
    engine_test::check_same(run, graph.run());
    poplar_test::check_same_words(mesh, graph);

    // The sum of heat is constant.
    double sum = 0, before = 0;
    for (std::uint32_t i = 0; i < grid.size(); ++i) {
        sum += static_cast<double>(graph.state<Cell>(grid.tile(i)).kelvin);
        before += 280.0 + i % 7;
    }
    CHECK(sum == doctest::Approx(before).epsilon(1e-5));
    engine_test::check_same(mesh.run(), graph.run()); // the second run continues from the first
    poplar_test::check_same_words(mesh, graph);
}

TEST_CASE("poplar: heat without counting supersteps needs no reduction")
{
    auto options = poplar_test::options("heat");
    options.count_exchanges = false;
    Mesh<Heat> mesh{program, Grid{5, 3}};
    PoplarMesh<Heat> graph{program, Grid{5, 3}, options};
    warm(mesh);
    warm(graph);
    auto const a = mesh.run(), b = graph.run();
    poplar_test::check_same_words(mesh, graph);
    CHECK(b.steps[0].passes == 1001);
    CHECK(b.steps[0].tile_runs == a.steps[0].tile_runs);
    CHECK(b.steps[0].messages == a.steps[0].messages);
    CHECK(b.steps[0].live_bytes == a.steps[0].live_bytes);
    CHECK(b.steps[0].exchanges == 0); // the option turns the count off
}
