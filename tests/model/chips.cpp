// A grid on several chips: the cycles of their borders by hand, in capacity and in messages, and in the files of a trace.
#include "../engine/everywhere.hpp"
#include "model_by_hand.hpp"
#include <tilemesh/model/chips.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/trace_files.hpp>

using namespace tilemesh;
using engine_test::error_of, engine_test::has, engine_test::model;

namespace {

/// Two chips of 2 x 2 tiles side by side. A border takes 50 cycles and 1 cycle a byte.
constexpr Grid grid{4, 2};
Chips const two{2, 2, 50, 1000, "by hand"};

CostModel on(Chips const& chips, ExchangeCost cost = ExchangeCost::capacity)
{
    auto m = model();
    m.exchange_cost = cost;
    m.chips = chips;
    return m;
}
/// Superstep 0 sends over the border: 12 + 20 bytes eastwards, 40 westwards; and 44 bytes southwards on a chip. Superstep 1 sends on chips
/// only. Superstep 2 has no channel.
Trace by_hand()
{
    Trace trace;
    trace.kernels = {"Send", "Stay", "Rest"};
    trace.supersteps = {{0, false, 24, true, {{1, {}, {0, 12, 0, 44}}, {2, {}, {0, 0, 40, 0}}, {5, {}, {0, 20, 0, 0}}}},
                        {1, false, 24, true, {{0, {}, {0, 16, 0, 0}}, {3, {}, {0, 99, 0, 0}}}}, // tile 3 sends over the grid's edge to itself
                        {2, false, 0, false, {{0, {}, {}}}}};
    return trace;
}

} // namespace

TEST_CASE("chips: whole channels cross each link of a border")
{
    auto const one = model_cost(on({}), by_hand(), grid), cost = model_cost(on(two), by_hand(), grid);
    for (std::size_t i : {0u, 1u}) {
        CAPTURE(i);
        CHECK(one.supersteps[i].exchange == 100 + 24); // 4 * 24 bytes at 0.25
        CHECK(one.supersteps[i].crossing == 0);
        CHECK(cost.supersteps[i].crossing_bytes == 48); // two links
        CHECK(cost.supersteps[i].crossing == 50 + 48 - 24);
        CHECK(cost.supersteps[i].exchange == 100 + 50 + 48);
    }
    CHECK(cost.supersteps[2].exchange == 0);
    CHECK(cost.cycles == one.cycles + 2 * 74);
    // Chips one above the other: a border has as many links as a chip has columns; a cut chip fewer rows than a whole one.
    CHECK(model_cost(on({4, 1, 50, 1000}), by_hand(), grid).supersteps[0].crossing_bytes == 4 * 24);
    CHECK(model_cost(on({3, 5, 50, 1000}), by_hand(), grid).supersteps[0].crossing_bytes == 2 * 24);
    CHECK(model_cost(on({1, 1, 50, 1000}), by_hand(), grid).supersteps[0].crossing_bytes == 24);
}

TEST_CASE("chips: messages cross the border in one direction or the other, and only if they leave their chip")
{
    auto const one = model_cost(on({}, ExchangeCost::live), by_hand(), grid), cost = model_cost(on(two, ExchangeCost::live), by_hand(), grid);
    CHECK(one.supersteps[0].exchange == 100 + 11); // tile 5 receives 44 bytes
    CHECK(cost.supersteps[0].crossing_bytes == 40);
    CHECK(cost.supersteps[0].exchange == 100 + 50 + 40);
    CHECK(cost.supersteps[0].crossing == 50 + 40 - 11);
    CHECK(cost.supersteps[1].crossing_bytes == 0);
    CHECK(cost.supersteps[1].exchange == one.supersteps[1].exchange);
    // With an edge that wraps, tile 3 sends to tile 0: over the border between the last and the first chip.
    auto around = by_hand();
    around.supersteps[1].edge = Edge::wrap;
    CHECK(model_cost(on(two, ExchangeCost::live), around, grid).supersteps[1].crossing_bytes == 99);
    // A border that is faster than the chips costs nothing.
    CHECK(model_cost(on({2, 2, 1, 0}, ExchangeCost::live), by_hand(), grid).cycles == one.cycles);
}

TEST_CASE("chips: a grid that fits one chip costs what it costs without chips")
{
    for (auto cost : {ExchangeCost::capacity, ExchangeCost::live}) {
        auto const plain = model_cost(on({}, cost), by_hand(), grid);
        for (auto const& chips : {Chips{4, 2, 50, 1000}, Chips{40, 36, 50, 1000}, Chips{0, 0, 50, 1000}})
            CHECK(model_cost(on(chips, cost), by_hand(), grid).cycles == plain.cycles);
    }
}

TEST_CASE("chips: the largest numbers are exact, larger ones are refused")
{
    auto trace = by_hand();
    trace.supersteps.resize(1);
    trace.supersteps[0].capacity_bytes = 0xffffffffu;
    trace.supersteps[0].tiles.clear();
    Grid const tall{2, 65535};
    auto const cost = model_cost(on({1, 65535, 1'000'000'000'000, 10'000'000}), trace, tall);
    CHECK(cost.supersteps[0].crossing_bytes == std::uint64_t{0xffffffffu} * 65535);
    CHECK(cost.supersteps[0].exchange == 100 + 1'000'000'000'000 + std::uint64_t{0xffffffffu} * 65535 * 10'000);
    auto const refused = [](Chips const& chips) { return error_of([&] { model_cost(on(chips), by_hand(), grid); }); };
    CHECK(has(refused({2, 2, 1'000'000'000'001, 0}), "1000000000001 cycles"));
    CHECK(has(refused({2, 2, 0, 10'000'001}), "10000001 millicycles a byte"));
    CHECK(has(refused({0, 2, 0, 0}), "chips of 0 x 2 tiles"));
    CHECK(has(refused({2, 0, 0, 0}), "chips of 2 x 0 tiles"));
}

TEST_CASE("chips: the files of a trace show the borders; a model's file refuses them")
{
    std::ostringstream csv, timeline, plain;
    write_step_csv(csv, by_hand(), on(two), grid);
    CHECK(has(csv.str(), "slowest_x,slowest_y,crossing_bytes,crossing_cycles,bound_by\n0,0,Send,3,10,198,7,0,1,0,48,74,border (0 0) e\n"));
    write_step_csv(plain, by_hand(), on({}), grid);
    CHECK_FALSE(has(plain.str(), "crossing"));
    write_chrome_trace(timeline, by_hand(), on(two), grid);
    CHECK(has(timeline.str(), "\"crossing_bytes\":48,\"crossing_cycles\":74"));
    auto model = mk2();
    model.chips = mk2_chips();
    std::ostringstream file;
    CHECK(has(error_of([&] { write_cost_model(file, model); }), "no line for its chips"));
}
