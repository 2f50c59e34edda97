// test: unoptimised test asan, without tsan
#include "model_by_hand.hpp"
#include <tilemesh/model/bottleneck.hpp>
#include <tilemesh/model/step_costs.hpp>

// The sentence that a page begins with: what limits a run, from traces put together by hand.
using namespace tilemesh;

namespace {
constexpr Grid grid{2, 2};
/// Prices a look at 1 cycle and a send at 10; to start a kernel takes 10, an exchange 100 and a quarter a byte, a sync 7, a vote 3.
CostModel priced()
{
    auto m = engine_test::model();
    m.prices = {{"look", 1000}, {"send", 10'000}};
    return m;
}
/// Step 0 once, step 1 three times. Tile 3 is the slowest in two of the three passes of step 1, tile 0 in the other.
Trace three_passes()
{
    Trace trace;
    trace.kernels = {"Begin", "Work"};
    trace.operations = {{"send"}, {"look", "send"}};
    trace.supersteps = {{0, false, 0, false, {{0, {{1}}, {}}, {1, {{1}}, {}}, {2, {{1}}, {}}, {3, {{1}}, {}}}},
                        {1, true, 40, true, {{0, {{90, 1}}, {0, 8, 0, 0}}, {3, {{400, 9}}, {8, 0, 0, 0}}}},
                        {1, true, 40, true, {{0, {{990}}, {}}, {3, {{100, 9}}, {40, 0, 0, 0}}}},
                        {1, true, 40, false, {{3, {{290}}, {}}}}};
    return trace;
}
std::string text_of(Trace const& trace, CostModel const& model, std::string const& because = "")
{
    auto const cost = model_cost(model, trace, grid);
    return bottleneck_text(find_bottleneck(model, trace, cost, grid), model, trace, cost, grid, "run", because);
}
} // namespace

TEST_CASE("bottleneck: the step that computes longest, and the tile for which its passes wait most")
{
    auto const trace = three_passes();
    auto const model = priced();
    auto const cost = model_cost(model, trace, grid);
    // Compute: 20; 10 + 400 + 90, 10 + 990, 10 + 290. Exchange: 3 * (100 + 40). Sync and vote: 7, 3 * 10.
    CHECK(cost.cycles == 20 + (500 + 1000 + 300) + 3 * 140 + 7 + 3 * 10);
    auto const found = find_bottleneck(model, trace, cost, grid);
    REQUIRE(found);
    CHECK(found->phase == Bottleneck::Phase::compute);
    CHECK(found->step == 1);
    CHECK(found->cycles == 1800);
    CHECK(found->passes == 3);
    CHECK(found->tile == 0); // 1,000 cycles in one pass are more than 500 + 300 in two
    CHECK(found->tile_passes == 1);
    CHECK(found->tile_cycles == 1000);
    CHECK(found->mean_cycles == doctest::Approx((110 + 1000 + 500 + 200 + 300) / 4.0));
    CHECK(found->operation == "look");
    CHECK(found->operation_cycles == 990);
    // 1,800 of 2,277 cycles; 1,800 to 527.5; 990 of 1,000.
    CHECK(text_of(trace, model) == "Slowest: step Work; 79.1 % of the run is its compute, 3.4 times the mean of all tiles, and for 55.6 % of that "
                                   "time (1 of 3 passes) all tiles wait for tile (0, 0); 99.0 % of the tile's compute is operation look.");
    CHECK(text_of(trace, model, "it has 5 things").find("wait for tile (0, 0), because it has 5 things; 99.0 %") != std::string::npos);
}

TEST_CASE("bottleneck: a tile that all passes wait for is named first")
{
    auto trace = three_passes();
    trace.supersteps.erase(trace.supersteps.begin() + 2); // 500 and 300 cycles of tile 3
    auto const cost = model_cost(priced(), trace, grid);
    auto const found = find_bottleneck(priced(), trace, cost, grid);
    REQUIRE(found);
    CHECK(found->tile == 3);
    CHECK(found->tile_cycles == 800);
    CHECK(found->operation_cycles == 400 + 290); // against 90 of `send` and 20 of two starts
    // 20 + 800 + 2 * 140 + 27 are 1,127 cycles; tiles compute 110 + 500 + 300, a fourth of that on average.
    CHECK(text_of(trace, priced(), "it has 5 things") ==
          "Slowest: tile (1, 1); 71.0 % of the run is its compute in step Work, 3.5 times the mean of all tiles, because it has 5 things; 86.2 % of "
          "that compute is operation look.");
    // The steps' names differ where their kernels do not.
    trace.kernels[0] = "Work";
    CHECK(text_of(trace, priced()).find("in step Work 2, ") != std::string::npos);
    // If another operation takes more, it is named.
    auto dear = priced();
    dear.prices[1].millicycles = 100'000;
    CHECK(text_of(trace, dear).find("; 55.9 % of that compute is operation send.") != std::string::npos); // 900 of 1,310 + 300
}

TEST_CASE("bottleneck: tiles that share the work evenly, and kernels that count nothing")
{
    Trace trace;
    trace.kernels = {"Work"};
    trace.supersteps = {{0, false, 0, false, {{0, {}, {}}, {1, {}, {}}, {2, {}, {}}, {3, {}, {}}}}};
    CHECK(text_of(trace, priced(), "of nothing") == "Slowest: step Work; 58.8 % of the run is its compute, which the tiles share evenly; "
                                                    "100.0 % of that compute is starting the kernel.");
    // 22 cycles against a mean of 20.5: a tenth more or less is even, more than that is not.
    trace.operations = {{"look"}};
    for (std::uint32_t t = 0; t < 4; ++t) trace.supersteps[0].tiles[t].operations.count[0] = 10;
    trace.supersteps[0].tiles[2].operations.count[0] = 12;
    CHECK(text_of(trace, priced()).find("share evenly") != std::string::npos);
    trace.supersteps[0].tiles[2].operations.count[0] = 14; // 24 against 21
    CHECK(text_of(trace, priced()).starts_with("Slowest: tile (0, 1); 77.4 % of the run is its compute in step Work, 1.1 times the mean"));
}

TEST_CASE("bottleneck: exchange, synchronisation, and a run that takes no time")
{
    auto const trace = three_passes();
    auto model = priced();
    model.exchange_cycles = 5000;
    CHECK(text_of(trace, model).starts_with("Slowest: the exchange of step Work; 89."));
    CHECK(text_of(trace, model).ends_with("moving the whole capacity of its channels after each of 3 passes, 40 bytes to each side of a tile, of "
                                          "which no side used more than 40."));
    model.exchange_cost = ExchangeCost::live; // the third sends nothing
    CHECK(text_of(trace, model).ends_with("its 2 exchanges, which move 56 bytes in all."));
    model = priced();
    model.sync_cycles = 500;
    model.vote_cycles = 500; // together 3,000 in step 1, where compute takes 1,800
    CHECK(text_of(trace, model).starts_with("Slowest: the synchronisation of step Work; "));
    CHECK(text_of(trace, model).ends_with(" of the run is waiting for all tiles after each of its 3 passes."));

    CostModel free;
    free.prices = {{"look", 0}, {"send", 0}};
    CHECK_FALSE(find_bottleneck(free, trace, model_cost(free, trace, grid), grid));
    CHECK(text_of(trace, free) == "The run took no modelled time: 4 passes.");
    CHECK(text_of({}, priced()) == "The run took no modelled time: 0 passes.");
}

TEST_CASE("bottleneck: of equals compute comes first, then the earlier step, then the lower tile")
{
    Trace trace;
    trace.kernels = {"A", "B"};
    trace.supersteps = {{1, false, 0, false, {{3, {}, {}}}}, {0, false, 0, false, {{1, {}, {}}}}, {0, false, 0, false, {}}, {1, false, 0, false, {{2, {}, {}}}}};
    auto model = priced();
    model.sync_cycles = 5; // twice in each step, and 20 cycles of compute in B, 10 in A
    auto const found = [&] { return find_bottleneck(model, trace, model_cost(model, trace, grid), grid).value(); };
    CHECK(found().step == 1);
    CHECK(found().tile == 2); // as long as tile 3 was the slowest before
    model.sync_cycles = 10;
    CHECK(found().phase == Bottleneck::Phase::compute);
    trace.supersteps[2].tiles = {{1, {}, {}}};
    CHECK(found().step == 0);
}

TEST_CASE("bottleneck: the slowest tile of a step and its operations; none of a step without compute")
{
    auto const trace = three_passes();
    auto const cost = model_cost(priced(), trace, grid);
    auto slowest = slowest_tile(priced(), trace, cost, grid, 0);
    REQUIRE(slowest);
    CHECK(slowest->tile == 0); // all four take as long
    CHECK(slowest->passes == 1);
    CHECK(slowest->cycles == 20);
    REQUIRE(slowest->operations.size() == 1);
    CHECK(slowest->operations[0].operation == "send");
    CHECK(slowest->operations[0].count == 1);
    CHECK(slowest->operations[0].cycles == 10);
    slowest = slowest_tile(priced(), trace, cost, grid, 1);
    REQUIRE(slowest);
    CHECK(slowest->tile == 0);
    REQUIRE(slowest->operations.size() == 1); // tile 0 sends only in a pass in which it is not the slowest
    CHECK(slowest->operations[0].count == 990);
    CHECK_FALSE(slowest_tile(priced(), trace, cost, grid, 2)); // there is no such step
    auto free = priced();
    free.run_cycles = 0;
    free.prices = {{"look", 0}, {"send", 0}};
    CHECK_FALSE(slowest_tile(free, trace, model_cost(free, trace, grid), grid, 1));
    CHECK_FALSE(slowest_tile(priced(), {}, {}, grid, 0));
}

TEST_CASE("bottleneck: without a cost model the passes, the exchanges and the most loaded tile")
{
    auto trace = three_passes();
    CHECK(load_text(trace, grid) ==
          "The run took 4 passes and 2 exchanges; the most loaded tile is (1, 1), which sent 48 bytes, 3.4 times the mean.");
    for (auto& s : trace.supersteps)
        for (auto& t : s.tiles)
            for (auto& bytes : t.sent_bytes) bytes = 0;
    CHECK(load_text(trace, grid, "frame") ==
          "The frame took 4 passes and 2 exchanges; the most loaded tile is (1, 1), which ran 4 times, 1.8 times the mean.");
    CHECK(load_text({}, grid) == "The run took 0 passes and 0 exchanges.");
    trace.supersteps.resize(1);
    CHECK(load_text(trace, grid).starts_with("The run took 1 pass and 0 exchanges; the most loaded tile is (0, 0), which ran 1 time, 1.0"));
    CHECK_THROWS_AS(load_text(trace, {1, 1}), Error);
}

TEST_CASE("bottleneck: steps of one kernel get numbers, and all names differ")
{
    Trace trace;
    trace.kernels = {"route", "bloom", "bloom", "sort"};
    CHECK(step_names(trace) == std::vector<std::string>{"route", "bloom 1", "bloom 2", "sort"});
    trace.kernels = {"bloom", "bloom", "bloom 2"};
    CHECK(step_names(trace) == std::vector<std::string>{"step 0: bloom 1", "step 1: bloom 2", "step 2: bloom 2"});
    CHECK(step_names({}).empty());
}
