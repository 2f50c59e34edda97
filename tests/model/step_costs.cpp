// test: unoptimised test asan, without tsan
#include "model_by_hand.hpp"
#include <tilemesh/model/cost_table.hpp>
#include <tilemesh/model/step_costs.hpp>

// A run's modelled cycles by step, and the table that examples print: by hand.
using namespace tilemesh;

namespace {
/// Three steps on two tiles: `first` twice with a vote, `second` never, `third` once without a channel.
Trace three_steps()
{
    Trace trace;
    trace.kernels = {"first", "second", "third"};
    trace.operations.assign(3, {"slot", "routed"});
    TileSample one{0, {}, {0, 0, 0, 0}}, other{1, {}, {0, 0, 0, 0}};
    one.operations[0] = 4;   // 2 cycles
    other.operations[1] = 3; // 18
    trace.supersteps.push_back({0, true, 24, true, {one, other}});
    trace.supersteps.push_back({0, true, 24, false, {one}});
    trace.supersteps.push_back({2, false, 0, false, {one, other}});
    return trace;
}
constexpr Grid grid{2, 1};
} // namespace

TEST_CASE("step costs: supersteps of a step are added up, and nothing is left over")
{
    auto const trace = three_steps();
    auto const cost = model_cost(engine_test::model(), trace, grid);
    auto const steps = step_costs(trace, cost);
    REQUIRE(steps.size() == 3);
    // Each exchange moves 4 * 24 bytes at a quarter of a cycle, and 100; compute is 10 and the slower tile's.
    CHECK(steps[0] == StepCost{"first", 2, 1, 3, 0, (10 + 18) + (10 + 2), 2 * 124, 2 * 7, 2 * 3});
    CHECK(steps[1] == StepCost{"second", 0, 0, 0, 0, 0, 0, 0, 0});
    CHECK(steps[2] == StepCost{"third", 1, 0, 2, 0, 28, 0, 7, 0});
    CHECK(steps[0].total() + steps[1].total() + steps[2].total() == cost.cycles);
    CHECK(steps[0].total() == 308);
}

TEST_CASE("step costs: a run without a superstep, a program without a step")
{
    Trace trace;
    trace.kernels = {"only"};
    CHECK(step_costs(trace, model_cost(engine_test::model(), trace, grid)) == std::vector<StepCost>{{"only", 0, 0, 0, 0, 0, 0, 0, 0}});
    CHECK(step_costs({}, {}).empty());
}

TEST_CASE("step costs: the costs of another trace are refused with a sentence")
{
    auto const trace = three_steps();
    auto const cost = model_cost(engine_test::model(), trace, grid);
    auto const refusal = [](Trace const& t, RunCost const& c) { return tests::error_of([&] { step_costs(t, c); }); };
    CHECK(refusal(trace, cost).empty());
    CHECK_THROWS_AS(step_costs([] { auto t = three_steps(); t.kernels.resize(2); return t; }()), Error);
    auto shorter = cost;
    shorter.supersteps.pop_back();
    CHECK(refusal(trace, shorter) == "the costs of 2 supersteps cannot be summed by step (the trace has 3, or they are of other steps); "
                                     "apply the model to this trace");
    auto other = cost;
    other.supersteps[1].step = 2;
    CHECK(refusal(trace, other).find("of other steps") != std::string::npos);
    auto beyond = trace; // a superstep of a step that the program does not have
    beyond.kernels.pop_back();
    CHECK_FALSE(refusal(beyond, cost).empty());
}

TEST_CASE("cost table: a row a step and their sum, in cycles and in milliseconds of the model's clock")
{
    auto const trace = three_steps();
    auto const m = engine_test::model(); // a cycle is a microsecond
    auto const cost = model_cost(m, trace, grid);
    std::ostringstream out;
    out << cost_table(m, trace, cost);
    CHECK(out.str() == "  step  passes  exchanges  compute  exchange  sync and vote  modelled ms\n"
                       "------  ------  ---------  -------  --------  -------------  -----------\n"
                       " first       2          1       40       248             20       0.3080\n"
                       "second       0          0        0         0              0       0.0000\n"
                       " third       1          0       28         0              7       0.0350\n"
                       "   sum       3          1       68       248             27       0.3430\n");
    CHECK(milliseconds_text(m, 12'345'678) == "12345.6780");
    CHECK(milliseconds_text(m, 0) == "0.0000");
}

TEST_CASE("rounds of loops: where the steps of a loop begin anew; a loop in a loop; rounds that cannot be told apart")
{
    Trace trace;
    trace.kernels = {"Start", "A", "B", "C", "D", "End"};
    auto const run = [&](std::vector<std::uint32_t> const& steps) {
        trace.supersteps.clear();
        for (auto const step : steps) trace.supersteps.push_back({step, false, 0, false, {}});
        return loop_rounds(trace);
    };
    using Rounds = std::vector<LoopRound>;
    CHECK(run({}).empty());
    CHECK(run({0, 1, 5}).empty()); // no loop
    trace.loops = {{1, 2, 3}};
    CHECK(run({0, 1, 2, 1, 1, 2, 2, 1, 2, 5}) == Rounds{{0, 1, 1, 2}, {0, 2, 3, 6}, {0, 3, 7, 8}});
    CHECK(run({1, 2, 1, 2, 1, 2}) == Rounds{{0, 1, 0, 1}, {0, 2, 2, 3}, {0, 3, 4, 5}});
    CHECK(run({0, 1, 2, 5, 0, 1, 2, 1, 2, 5}) == Rounds{{0, 1, 1, 2}, {0, 2, 5, 6}, {0, 3, 7, 8}}); // the loop is begun twice
    CHECK(run({0, 1, 2, 1, 2, 5}).empty()); // two are seen, and three were made
    CHECK(run({0, 5}).empty());
    // Of a loop with one step every pass is a round, unless a round has several.
    trace.loops = {{3, 3, 2}};
    CHECK(run({0, 3, 3, 5}) == Rounds{{0, 1, 1, 1}, {0, 2, 2, 2}});
    CHECK(run({0, 3, 3, 3, 5}).empty());
    // The outer loop is A, B, C, D, and the inner one B, C.
    trace.loops = {{1, 4, 2}, {2, 3, 3}};
    CHECK(run({0, 1, 2, 3, 2, 3, 4, 1, 2, 3, 4, 5}) ==
          Rounds{{0, 1, 1, 6}, {0, 2, 7, 10}, {1, 1, 2, 3}, {1, 2, 4, 5}, {1, 3, 8, 9}});
}
