// test: unoptimised test asan tsan
#include "../engine/control.hpp"
#include "on_poplar.hpp"

// Loops, conditions and reductions as a Poplar graph. It gives the words, counters and traces of a Mesh.
using namespace engine_test;
using tilemesh::detail::BeginReduce;
using tilemesh::detail::GoOnReducing;

namespace {
constexpr auto to_one = ReduceTo::one;
constexpr auto to_all = ReduceTo::all;
} // namespace
using Nested = NestedDraining;
using Weighing = Sequence<Reduce<Weight, Sum, to_one>, Reduce<Bits, And, to_all>>;

VERTEX(drain_OpenTap, Traced<Mk2>, Draining, OpenTap)
VERTEX(drain_Drain, Traced<Mk2>, Draining, Drain)
VERTEX(drain_Refill, Traced<Mk2>, Draining, Refill)
VERTEX(nested_OpenTap, Mk2, Nested, OpenTap)
VERTEX(nested_Drain, Mk2, Nested, Drain)
VERTEX(nested_Refill, Mk2, Nested, Refill)
VERTEX(warm_Warm, Mk2, Warming, Warm)
VERTEX(warm_Spread, Mk2, Warming, Spread)
VERTEX(warm_Cool, Mk2, Warming, Cool)
VERTEX(warm_most_change_of_all_begin, Mk2, Warming, BeginReduce<Change, Most, to_all>)
VERTEX(warm_most_change_of_all, Mk2, Warming, GoOnReducing<Change, Most, to_all>)
VERTEX(warm_Judge, Mk2, Warming, Judge)
VERTEX(warm_Forget, Mk2, Warming, Forget)
VERTEX(choose_add_one, Mk2, Choosing, Add<1>)
VERTEX(choose_add_ten, Mk2, Choosing, Add<10>)
VERTEX(choose_add_hundred, Mk2, Choosing, Add<100>)
VERTEX(weigh_sum_weight_begin, Mk2, Weighing, BeginReduce<Weight, Sum, to_one>)
VERTEX(weigh_sum_weight, Mk2, Weighing, GoOnReducing<Weight, Sum, to_one>)
VERTEX(weigh_and_bits_of_all_begin, Mk2, Weighing, BeginReduce<Bits, And, to_all>)
VERTEX(weigh_and_bits_of_all, Mk2, Weighing, GoOnReducing<Bits, And, to_all>)
VERTEX(work_Ring, Mk2, Working<true>, Ring)
VERTEX(work_work_and_log, Mk2, Working<true>, Work<true>)
VERTEX(work_work, Mk2, Working<false>, Work<false>)
VERTEX(work_add_hundred, Mk2, Working<false>, Add<100>)

namespace {
using poplar_test::on_both;

auto const fill = [](auto& mesh) {
    for (std::uint32_t i = 0; i < mesh.grid().size(); ++i) mesh.template state<Tank>(mesh.grid().tile(i)) = {i % 4, i % 3, 0, 0};
};

TEST_CASE("poplar: a Loop takes the rounds of a Mesh, with an UntilQuiet and a Loop in it, up to its bound")
{
    for (Grid const grid : {Grid{1, 1}, Grid{5, 1}, Grid{1, 4}, Grid{4, 3}})
        for (std::uint32_t const at_most : {0u, 1u, 0xffffffffu}) {
            CAPTURE(grid.width);
            CAPTURE(at_most);
            Draining program;
            std::get<1>(program.steps).at_most = at_most;
            auto const runs = on_both<Draining, Traced<Mk2>>("drain", grid, fill, 2, program);
            if (grid.size() > 2 && at_most != 0) CHECK(runs[0].loops[0].rounds == std::min(3u, at_most));
            if (grid.size() == 1) CHECK(runs[0].loops[0].rounds == 0); // the only tile has no water, so no tile votes busy
        }
    Nested nested;
    std::get<0>(std::get<1>(nested.steps).steps).at_most = 2;
    auto const runs = on_both<Nested>("nested", Grid{4, 3}, fill, 1, nested);
    CHECK(runs[0].loops[0].rounds == 3);
    CHECK(runs[0].loops[1].rounds > 3);
}

TEST_CASE("poplar: a Loop that a reduction ends, and an If in it")
{
    for (Grid const grid : {Grid{1, 1}, Grid{4, 1}, Grid{1, 3}, Grid{3, 3}})
        for (std::uint32_t const cooled : {0u, 1u}) {
            auto const runs = on_both<Warming>("warm", grid, [&](auto& mesh) {
                mesh.template broadcast<Settling>() = {0.2f, 0.25f, cooled};
                for (std::uint32_t i = 0; i < grid.size(); ++i) mesh.template state<Plate>(grid.tile(i)).kelvin = static_cast<float>((i * 7 + 3) % 11);
            });
            auto const rounds = runs[0].loops[0].rounds;
            CHECK(rounds >= 1);
            CHECK(runs[0].steps[2].passes == (cooled != 0 ? rounds : 0));
        }
}

TEST_CASE("poplar: If, with supersteps counted or not")
{
    for (std::uint32_t const first : {0u, 1u})
        for (std::uint32_t const second : {0u, 6u}) {
            auto const load = [&](auto& mesh) { mesh.template broadcast<Wanted>() = {0, first, second}; };
            on_both<Choosing>("choose", Grid{3, 2}, load, 2);
            auto options = poplar_test::options("choose");
            options.count_exchanges = false;
            Mesh<Choosing> mesh{{}, Grid{3, 2}};
            PoplarMesh<Choosing> graph{{}, Grid{3, 2}, options};
            load(mesh);
            load(graph);
            check_same(mesh.run(), graph.run()); // no step sends, so both count no exchange
            poplar_test::check_same_words(mesh, graph);
            mesh.broadcast<Wanted>().first ^= 1u; // the second run uses the same graph
            graph.broadcast<Wanted>().first ^= 1u;
            check_same(mesh.run(), graph.run());
            poplar_test::check_same_words(mesh, graph);
        }
}

TEST_CASE("poplar: arguments and steps that are left out have no edge and no compute set")
{
    on_both<Working<true>>("work", Grid{3, 2}, [](auto&) {}, 2);
    on_both<Working<false>>("work", Grid{3, 2}, [](auto&) {}, 2);
}

TEST_CASE("poplar: Reduce, to one and to all")
{
    for (Grid const grid : {Grid{1, 1}, Grid{6, 1}, Grid{1, 5}, Grid{4, 3}})
        on_both<Weighing>("weigh", grid, [](auto& mesh) {
            for (std::uint32_t i = 0; i < mesh.grid().size(); ++i)
                mesh.template state<Load>(mesh.grid().tile(i)) = {static_cast<float>(i) * 0.1f, ~(1u << i)};
        }, 2);
}

TEST_CASE("poplar: reduce_on of another grid is refused when the mesh is built")
{
    using Known = decltype(reduce_on<Weight, Sum>({3, 2}));
    auto const refused = [](Grid grid) {
        return error_of([&] { PoplarMesh<Known> mesh{reduce_on<Weight, Sum>({3, 2}), grid, poplar_test::options("weigh")}; });
    };
    CHECK(refused({3, 2}).empty());
    CHECK(has(refused({3, 3}), "for a grid of 3 x 2 tiles (the mesh has 3 x 3)"));
}

TEST_CASE("poplar: the graph's variables are the ledger of programs with loops, conditions and reductions")
{
    poplar_test::check_ledger<Warming>("warm", Grid{6, 5});
    poplar_test::check_ledger<Nested>("nested", Grid{6, 5});
}
} // namespace
