#include "../engine/sides.hpp"
#include <tilemesh/model/chips.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/energy.hpp>
#include <tilemesh/model/exchange.hpp>

// What an exchange costs on channels that have some of the four sides: Cannon's product, with two ends a channel and with eight.
using namespace engine_test;
using namespace engine_test::on_edges;

namespace {
constexpr Grid grid{cannon_side, cannon_side};

template <bool Full>
Trace cannon_trace()
{
    Mesh mesh{cannon<Full>(), grid, Traced<Mk2>{}};
    load_cannon(mesh);
    mesh.run();
    return mesh.trace();
}
} // namespace

TEST_CASE("sides: a compiled exchange moves the ends that there are")
{
    auto const some = cannon_trace<false>(), full = cannon_trace<true>();
    auto model = mk2();
    model.exchange_millicycles_a_byte = 1000;
    model.exchange_cost = ExchangeCost::capacity;
    auto const a = model_cost(model, some, grid), b = model_cost(model, full, grid);
    CHECK(a.supersteps[0].compute == b.supersteps[0].compute);
    CHECK(a.supersteps[0].exchange == model.exchange_cycles + 2 * (8 + 4)); // a byte a cycle: one end of A, one of B
    CHECK(b.supersteps[0].exchange == model.exchange_cycles + 8 * (8 + 4));
    // Live messages cost the same: a tile receives one of each.
    model.exchange_cost = ExchangeCost::live;
    CHECK(model_cost(model, some, grid).cycles == model_cost(model, full, grid).cycles);
}

TEST_CASE("sides: over a border between chips goes one side")
{
    auto const trace = cannon_trace<false>();
    auto model = mk2();
    model.exchange_cost = ExchangeCost::capacity;
    model.chips.columns = 3; // two chips beside each other, of 3 and 2 columns
    model.chips.rows = cannon_side;
    model.chips.crossing_millicycles_a_byte = 1'000'000;
    auto const cost = model_cost(model, trace, grid);
    CHECK(cost.supersteps[0].crossing_bytes == cannon_side * (8 + 4)); // westwards, a row each
    CHECK(cost.supersteps[0].bound.side == 'w');
    CHECK(cost.supersteps[0].bound.at.x == 1); // from the second chip
    model.chips.columns = cannon_side;
    model.chips.rows = 4;
    auto const down = model_cost(model, trace, grid);
    CHECK(down.supersteps[0].crossing_bytes == cannon_side * (8 + 4));
    CHECK(down.supersteps[0].bound.side == 'n');
    CHECK(down.supersteps[0].bound.at.y == 1);
}

TEST_CASE("sides: transfers of an exchange go to the sides that there are")
{
    auto const model = mk2();
    auto const network = exchange_network(model, grid);
    auto const nodes = nodes_of(network, grid);
    auto const of = [&](Trace const& trace) { return exchange_transfers(network, nodes, trace.supersteps[0], grid, ExchangeCost::capacity); };
    auto const some = of(cannon_trace<false>()), full = of(cannon_trace<true>());
    CHECK(some.size() == 2 * grid.size());
    CHECK(full.size() == 4 * grid.size());
    for (auto const& t : some) CHECK(t.bytes == 8 + 4);
    for (auto const& t : full) CHECK(t.bytes == 2 * (8 + 4));
}
