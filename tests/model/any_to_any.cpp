// test: unoptimised test asan, without tsan
#include "../engine/everywhere.hpp"
#include "model_by_hand.hpp"
#include <tilemesh/model/any_to_any.hpp>

// The bound of an exchange from any tile to any tile: an example computed by hand, the reports of kernels, and refusals.
using namespace engine_test;

namespace {
/// A row of four tiles. Step 0 computes. Step 1 routes: tile 0 sends three messages of 8 bytes eastwards, to tiles 1, 2 and 3. In each
/// superstep one message stays and the others go on. Step 2 takes nothing and sends nothing, but votes once.
Trace by_hand()
{
    Trace trace;
    trace.kernels = {"compute", "route", "wait"};
    trace.supersteps = {{0, false, 0, false, {{0, {}, {}}}},
                        {1, true, 32, true, {{0, {}, {0, 8 + 24, 0, 0}}}},
                        {1, true, 32, true, {{1, {{}, 8}, {0, 8 + 16, 0, 0}}}},
                        {1, true, 32, true, {{2, {{}, 8}, {0, 8 + 8, 0, 0}}}},
                        {1, true, 32, false, {{3, {{}, 8}, {}}}},
                        {2, true, 0, false, {{0, {}, {}}}}};
    return trace;
}
constexpr Grid row{4, 1};
} // namespace

TEST_CASE("any to any: four tiles in a row, by hand")
{
    auto m = model(); // 100 cycles per exchange, 0.25 per byte, 7 per sync, 3 per vote
    m.exchange_cost = ExchangeCost::live;
    auto const a = any_to_any(m, by_hand(), row);
    REQUIRE(a.steps.size() == 3);
    CHECK(a.steps[0].news_cycles == 7);
    CHECK(a.steps[0].bound_cycles == 7);
    CHECK(!a.steps[0].replaced);

    // 108 + 106 + 104 + 0, four syncs and four votes. The bound: one exchange in which no tile takes more than one message.
    auto const& route = a.steps[1];
    CHECK(route.kernel == "route");
    CHECK(route.supersteps == 4);
    CHECK(route.news_cycles == 108 + 106 + 104 + 4 * (7 + 3));
    CHECK(route.replaced);
    CHECK(route.sent_bytes == 32 + 24 + 16);
    CHECK(route.settled_bytes == 24);
    CHECK(route.busiest_bytes == 8);
    CHECK(route.busiest == 1);
    CHECK(route.bound_cycles == 100 + 2 + 7);

    CHECK(a.steps[2].news_cycles == 10);
    CHECK(a.steps[2].bound_cycles == 10);
    CHECK(a.news_cycles == 7 + 358 + 10);
    CHECK(a.bound_cycles == 7 + 109 + 10);
    CHECK(a.supersteps_replaced == 4);
    CHECK(a.exchanges == 1);

    // Hop by hop, copies of whole channels cost more; the bound moves live messages only.
    m.exchange_cost = ExchangeCost::capacity;
    auto const c = any_to_any(m, by_hand(), row);
    CHECK(c.steps[1].news_cycles == 4 * (100 + 32 + 7 + 3));
    CHECK(c.steps[1].bound_cycles == 109);
}

TEST_CASE("any to any: bytes of one tile are added up over supersteps, and rounded up once")
{
    auto trace = by_hand();
    trace.supersteps[3].tiles = {{1, {{}, 1}, {}}, {2, {{}, 8}, {0, 16, 0, 0}}};
    auto const a = any_to_any(model(), trace, row);
    CHECK(a.steps[1].busiest == 1);
    CHECK(a.steps[1].busiest_bytes == 9);
    CHECK(a.steps[1].bound_cycles == 100 + 3 + 7);
}

TEST_CASE("any to any: successive steps of one kernel count as one")
{
    auto trace = by_hand();
    trace.kernels = {"compute", "route", "route", "wait"};
    trace.supersteps[1].votes = false; // Superstep, then UntilQuiet
    for (std::size_t i = 2; i < 5; ++i) trace.supersteps[i].step = 2;
    trace.supersteps[5].step = 3;
    auto const a = any_to_any(model(), trace, row);
    REQUIRE(a.steps.size() == 3);
    CHECK(a.steps[1].first == 1);
    CHECK(a.steps[1].last == 2);
    CHECK(a.steps[1].supersteps == 4);
    CHECK(a.steps[1].news_cycles == 4 * (100 + 32 + 7) + 3 * 3);
    CHECK(a.steps[1].bound_cycles == 109);
    CHECK(a.steps[2].first == 3);
}

TEST_CASE("any to any: runs that settle differently are different")
{
    OperationCounts a;
    a[0] = 3;
    a.settled_bytes = 8;
    auto b = a;
    CHECK(a == b);
    b.settled_bytes = 4;
    CHECK(!(a == b));
    CHECK(OperationCounts{}.settled_bytes == 0);
}

TEST_CASE("any to any: nothing sent, nothing settled, nothing run")
{
    auto sent_only = by_hand(); // a bound cut the step: all messages are still under way
    for (auto& s : sent_only.supersteps)
        for (auto& t : s.tiles) t.operations.settled_bytes = 0;
    auto const a = any_to_any(model(), sent_only, row);
    CHECK(a.steps[1].replaced);
    CHECK(a.steps[1].bound_cycles == 0);
    CHECK(a.exchanges == 0);
    CHECK(a.supersteps_replaced == 4);

    Trace none;
    CHECK(any_to_any(model(), none, row).steps.empty());
    none.kernels = {"K"};
    CHECK(any_to_any(model(), none, row).bound_cycles == 0);
    CHECK(!any_to_any(model(), none, row).steps[0].replaced);
}

TEST_CASE("any to any: another grid, and numbers too large, are refused")
{
    CHECK(has(error_of([] { any_to_any(model(), by_hand(), {3, 1}); }), "give the trace and the grid of one run"));
    auto m = model();
    m.exchange_millicycles_a_byte = most_millicycles + 1;
    CHECK(has(error_of([&] { any_to_any(m, by_hand(), row); }), "give it smaller numbers"));

    // 43 supersteps of 2^32 - 1 bytes at 100,000 cycles are 1.8469e19 millicycles, just above 64 bits; 42 fit. Nothing was sent in this
    // run, so that its cost by hops stays small.
    m.exchange_millicycles_a_byte = most_millicycles;
    Trace trace;
    trace.kernels = {"K"};
    auto const settle = [&](std::uint32_t times) {
        trace.supersteps.assign(times, {0, true, 0, false, {{0, {{}, 0xffffffffu}, {}}}});
        return any_to_any(m, trace, {1, 1});
    };
    constexpr std::uint64_t bytes = 42 * std::uint64_t{0xffffffffu};
    CHECK(settle(42).bound_cycles == 100 + bytes * (most_millicycles / 1000) + 7);
    CHECK(error_of([&] { settle(43); }) == "an exchange from any tile to any tile cannot be modelled (step 0, K: its cycles pass 64 "
                                           "bits); give the cost model smaller numbers");
}

namespace {
struct Parcel {
    std::uint32_t to, payload;
};
struct Held {
    std::uint32_t parcels;
};
struct Belt : Channel<Parcel, 4> {};
struct Carrying {
    enum Kind : std::uint32_t { looked };
    static constexpr char const* names[] = {"looked"};
};
/// Sends a parcel eastwards to the tile that it names.
struct Carry {
    void operator()(Here here, Held& held, In<Belt> in, Out<Belt> out) const noexcept
    {
        for (auto const& p : in[Direction::west])
            if (p.to == here.tile.x()) ++held.parcels;
            else out[Direction::east].push(p);
    }
    static Operations<Carrying> operations(Here here, In<Belt> in) noexcept
    {
        Operations<Carrying> o;
        for (auto const& p : in[Direction::west]) o.settled_bytes += p.to == here.tile.x() ? wire_bytes<Parcel> : 0;
        return o;
    }
};
struct Start {
    void operator()(Here here, Out<Belt> out) const noexcept
    {
        if (here.tile.x() == 0)
            for (std::uint32_t to : {1u, 3u, 3u}) out[Direction::east].push({to, 7});
    }
};
} // namespace

TEST_CASE("any to any: the bytes that kernels report as settled are equal on every engine")
{
    using Program = Sequence<Superstep<Start>, UntilQuiet<Carry>>;
    on_each<Program, Traced<Mk2>>(row, [](auto& mesh) {
        mesh.run();
        auto const a = any_to_any(model(), mesh.trace(), row);
        CHECK(a.steps[0].bound_cycles == 0); // it only sends; no message ends there
        CHECK(a.steps[1].settled_bytes == 3 * 8);
        CHECK(a.steps[1].busiest == 3);
        CHECK(a.steps[1].busiest_bytes == 16);
        CHECK(a.steps[1].bound_cycles == 100 + 4 + 7);
        CHECK(a.supersteps_replaced == mesh.trace().supersteps.size());
    });
}
