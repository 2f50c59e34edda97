// test: unoptimised test asan tsan
#include "../engine/everywhere.hpp"
#include "model_by_hand.hpp"
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/energy.hpp>
#include <tilemesh/model/trace_files.hpp>

// A program without splatting that has its own operations: an odd-even transposition sort of one number per tile, priced by hand.
using namespace engine_test;

namespace {
struct Sorting {
    enum Kind : std::uint32_t { compare, swap };
    static constexpr char const* names[] = {"compare", "swap"};
};
struct Cell {
    std::uint32_t value, round, compared, swapped;
};
struct Wire : Channel<std::uint32_t, 1> {};
constexpr Grid row{4, 1};
constexpr std::uint32_t unsorted[] = {4, 3, 1, 2};

/// Takes the number that the partner of the last round sent, then offers its own number to the partner of this round.
struct Transpose {
    void operator()(Here here, Cell& cell, In<Wire> in, Out<Wire> out) const noexcept
    {
        cell.compared = cell.swapped = 0;
        for (Direction side : {Direction::west, Direction::east})
            for (std::uint32_t const other : in[side]) {
                bool const takes = side == Direction::east ? other < cell.value : other > cell.value;
                ++cell.compared;
                cell.swapped += takes ? 1u : 0u;
                if (takes) cell.value = other;
            }
        bool const eastwards = (here.tile.x() + cell.round++) % 2 == 0;
        if (eastwards ? here.tile.x() + 1 < row.width : here.tile.x() > 0) out[eastwards ? Direction::east : Direction::west].push(cell.value);
    }
    static Operations<Sorting> operations(Cell const& cell) noexcept
    {
        Operations<Sorting> o;
        o[Sorting::compare] = cell.compared;
        o[Sorting::swap] = cell.swapped;
        return o;
    }
};
using Sort = Repeat<Transpose>;

CostModel sorter()
{
    auto m = model(); // run 10 cycles, exchange 100 and 0.25 per byte, sync 7
    m.name = "sorter";
    m.prices.clear();
    set_price(m, "compare", 3000, "a test");
    set_price(m, "swap", 2500, "a test");
    return m;
}
/// 4 3 1 2, 3 4 1 2, 3 1 4 2, 1 3 2 4, 1 2 3 4.
Trace sorted()
{
    Trace trace;
    on_each<Sort, Traced<Mk2>>(row, [&](auto& mesh) {
        for (std::uint32_t i = 0; i < 4; ++i) mesh.template state<Cell>(row.tile(i)).value = unsorted[i];
        mesh.run();
        for (std::uint32_t i = 0; i < 4; ++i) CHECK(mesh.template state<Cell>(row.tile(i)).value == 1 + i);
        if (trace.kernels.empty()) trace = mesh.trace();
        CHECK(mesh.trace() == trace);
    }, {5});
    return trace;
}
} // namespace

TEST_CASE("own operations: a sorting network is priced by the names of its own operations")
{
    auto const trace = sorted();
    CHECK(trace.operations == std::vector<std::vector<std::string>>{{"compare", "swap"}});
    CHECK(heat_map(trace, row, "compare") == std::vector<double>{2, 4, 4, 2});
    CHECK(heat_map(trace, row, "swap") == std::vector<double>{2, 4, 3, 1});

    // Compute: 10 in the first superstep; then a tile that compares and swaps is the slowest in each of four: 10 + 5.5, rounded up.
    // Exchange: four ends of 12 bytes at a quarter of a cycle, and 100. Sync 7.
    auto const cost = model_cost(sorter(), trace, row);
    REQUIRE(cost.supersteps.size() == 5);
    CHECK(cost.supersteps[0].compute == 10);
    for (std::size_t i = 1; i < 5; ++i) CHECK(cost.supersteps[i].compute == 16);
    CHECK(cost.cycles == 10 + 4 * 16 + 5 * 112 + 5 * 7);
    CHECK(cost.busy[0] == std::vector<std::uint64_t>{10 + 16 + 10 + 16 + 10, 10 + 4 * 16, 10 + 13 + 3 * 16, 10 + 13 + 10 + 16 + 10});

    std::ostringstream csv;
    write_trace_csv(csv, trace, sorter(), row);
    CHECK(csv.str().starts_with("superstep,step,kernel,tile_x,tile_y,compare,swap,north_bytes,east_bytes,west_bytes,south_bytes,settled_bytes,"
                                "compute_cycles\n0,0,Transpose,0,0,0,0,0,12,0,0,0,10\n"));
    CHECK(csv.str().find("\n1,0,Transpose,1,0,1,1,0,12,0,0,0,16\n") != std::string::npos);

    EnergyModel joules;
    joules.name = "sorter";
    for (auto const* event : {"compare", "swap", "capacity_byte", "tile_cycle"}) set_energy(joules, event, 1, "a test");
    auto const energy = energy_of(joules, sorter(), trace, row);
    CHECK(energy.of("compare").count == 12);
    CHECK(energy.of("swap").count == 10);
    CHECK(energy.of("swap").joules == 10 / 1e15);
}

TEST_CASE("own operations: an operation without a price is refused by name; one that does not occur needs none")
{
    auto const trace = sorted();
    auto m = sorter();
    m.prices.pop_back();
    CHECK(error_of([&] { model_cost(m, trace, row); }) ==
          "cost model \"sorter\" cannot be applied (operation swap of kernel Transpose occurs, first in superstep 1, and has no price); give "
          "it one (set_price, or a line of the model's file), and say where it is from");
    CHECK(has(error_of([&] { model_cost(mk2(), trace, row); }), "operation compare of kernel Transpose"));
    CHECK(error_of([&] { price_of(m, "swap"); }) ==
          "cost model \"sorter\" has no price for operation swap (it prices compare); give it one (set_price, or a line of the model's file)");
    auto still = trace;
    for (auto& s : still.supersteps)
        for (auto& t : s.tiles) t.operations[Sorting::swap] = 0;
    CHECK(model_cost(m, still, row).cycles == 10 + 4 * 13 + 5 * 112 + 5 * 7);
    still.operations[0].clear(); // counts without names
    CHECK(has(error_of([&] { model_cost(m, still, row); }), "operation number 0, which has no name, of kernel Transpose occurs"));
    still.operations[0].assign(9, "x");
    CHECK(has(error_of([&] { heat_map(still, row, "x"); }), "names 9 operations, and 8 can be counted"));
}

TEST_CASE("own operations: steps with different operations share the columns of the names they share")
{
    Trace trace;
    trace.kernels = {"Transpose", "Merge"};
    trace.operations = {{"compare", "swap"}, {"copy", "compare"}};
    trace.supersteps = {{0, false, 0, false, {{0, {{5, 6}}, {}}}}, {1, false, 0, false, {{0, {{7, 8}}, {}}}}};
    auto m = sorter();
    set_price(m, "copy", 1000, "a test");
    CHECK(model_cost(m, trace, row).cycles == (10 + 15 + 15) + 7 + (10 + 7 + 24) + 7);
    std::ostringstream csv;
    write_trace_csv(csv, trace, m, row);
    CHECK(csv.str().find(",tile_y,compare,swap,copy,north_bytes") != std::string::npos);
    CHECK(csv.str().find("\n0,0,Transpose,0,0,5,6,0,0,") != std::string::npos);
    CHECK(csv.str().find("\n1,1,Merge,0,0,8,0,7,0,") != std::string::npos);
    CHECK(heat_map(trace, row, "compare") == std::vector<double>{13, 0, 0, 0});
}

TEST_CASE("own operations: prices as a file, and names that a file cannot hold")
{
    std::stringstream file;
    auto m = mk2();
    set_price(m, "swap", 2500, "a test");
    write_cost_model(file, m);
    auto const again = read_cost_model(file, "file");
    CHECK(again == m);
    CHECK(price_of(again, "swap") == 2500);
    CHECK(again.parameters[19].name == "swap"); // after the seventeen prices that it had
    set_parameter(m, "swap", 7, "another test");
    CHECK(price_of(m, "swap") == 7);
    auto const before = m;
    for (std::string const& name : std::vector<std::string>{"", "#a", "a b", "caf\xc3\xa9", "sync", "clock", std::string(65, 'x')})
        CHECK(has(error_of([&] { set_price(m, name, 1, "x"); }), "cannot be priced"));
    CHECK(has(error_of([&] { set_price(m, "new", most_millicycles + 1, "x"); }), "parameter new cannot be"));
    CHECK(has(error_of([&] { set_price(m, "new", 1, ""); }), "parameter new has no source"));
    CHECK(m == before);
}
