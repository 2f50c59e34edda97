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

TEST_CASE("poplar: heat on 40 x 36 tiles is the same program, bit for bit; one tile, one row, one column")
{
    Grid const grid = engine_test::fast() ? Grid{8, 5} : Grid{40, 36};
    standin::Restore const restore;
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
    engine_test::check_same(mesh.run(), graph.run()); // the second run continues from the first
    poplar_test::check_same_words(mesh, graph);
    for (Grid const small : {Grid{1, 1}, Grid{6, 1}, Grid{1, 6}}) poplar_test::on_both<Heat>("heat", small, [](auto& m) { warm(m); }, 1, Heat{20});
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

TEST_CASE("poplar: the graph's variables are the ledger of heat, byte for byte")
{
    poplar_test::check_ledger<Heat>("heat", Grid{6, 5});
    poplar_test::check_ledger<Heat>("heat", Grid{7, 1});
}
