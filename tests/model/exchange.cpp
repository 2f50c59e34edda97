// test: unoptimised test asan
// Every exchange of a cost model is one of a network: compiled exchanges, several chips and an exchange from any tile to any tile cost the same,
// to the cycle; a network's own exchange by hand; what bounds a superstep.
#include "../engine/everywhere.hpp"
#include "../splat/support.hpp"
#include "model_by_hand.hpp"
#include <tilemesh/model/any_to_any.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/exchange.hpp>
#include <tilemesh/model/trace_files.hpp>

using namespace tilemesh;
using engine_test::error_of, engine_test::has, engine_test::model;

namespace {

/// The same exchange as a network.
CostModel on_network(CostModel m, Grid grid)
{
    m.network = exchange_network(m, grid);
    m.exchange_cycles = 0, m.exchange_millicycles_a_byte = 0, m.chips = {};
    return m;
}
/// Some tiles send some bytes to some sides.
Trace random_trace(Grid grid, support::Random& random)
{
    Trace trace;
    trace.kernels = {"Any"};
    for (std::uint32_t i = 0; i < 8; ++i) {
        SuperstepSample s{};
        s.capacity_bytes = random.below(3) == 0 ? 0 : 4 * random.below(500);
        for (std::uint32_t t = 0; t < grid.size(); ++t) {
            if (random.below(3) == 0) continue;
            TileSample tile{};
            tile.tile = t;
            for (auto& bytes : tile.sent_bytes) {
                bytes = random.below(2) == 0 ? 0 : random.below(3000);
                s.sent = s.sent || bytes != 0;
            }
            tile.operations.settled_bytes = random.below(2) == 0 ? 0 : random.below(900);
            s.tiles.push_back(tile);
        }
        trace.supersteps.push_back(s);
    }
    return trace;
}

} // namespace

TEST_CASE("a compiled exchange, on one chip or several, is one of a network: the same cycles and the same bound")
{
    support::Random random(77);
    for (std::uint32_t i = 0; i < 60; ++i) {
        Grid const grid{1 + random.below(7), 1 + random.below(7)};
        auto m = model();
        m.exchange_cost = i % 2 == 0 ? ExchangeCost::live : ExchangeCost::capacity;
        m.exchange_cycles = random.below(400);
        m.exchange_millicycles_a_byte = random.below(5) == 0 ? 0 : random.below(2500);
        if (i % 3 != 0) m.chips = {1 + random.below(3), 1 + random.below(3), random.below(900), random.below(700), "by hand"};
        auto const trace = random_trace(grid, random);
        auto const compiled = model_cost(m, trace, grid), network = model_cost(on_network(m, grid), trace, grid);
        INFO("trace ", i);
        REQUIRE(compiled.cycles == network.cycles);
        for (std::size_t k = 0; k < trace.supersteps.size(); ++k) {
            CHECK(compiled.supersteps[k].exchange == network.supersteps[k].exchange);
            auto const &a = compiled.supersteps[k].bound, &b = network.supersteps[k].bound;
            CHECK(a.kind == b.kind);
            if (m.exchange_cost == ExchangeCost::live && a.kind == NetworkResource::port_in) CHECK(a.at == b.at);
        }
    }
}

TEST_CASE("an exchange from any tile to any tile is one of the same network")
{
    support::Random random(78);
    for (std::uint32_t i = 0; i < 20; ++i) {
        Grid const grid{1 + random.below(7), 1 + random.below(7)};
        auto m = model();
        m.exchange_cost = ExchangeCost::live;
        auto const trace = random_trace(grid, random);
        auto const ideal = any_to_any(m, trace, grid);
        REQUIRE(ideal.steps.size() == 1);
        auto const network = exchange_network(m, grid);
        auto const nodes = nodes_of(network, grid);
        std::vector<NetworkTransfer> phase; // from anywhere: distance costs nothing
        for (auto const& s : trace.supersteps)
            for (auto const& t : s.tiles)
                if (t.operations.settled_bytes != 0)
                    phase.push_back({nodes[random.below(grid.size())], nodes[t.tile], NetworkWay::rows_first, t.operations.settled_bytes, t.tile});
        if (phase.empty()) continue;
        CHECK(ideal.steps[0].bound_cycles == time_of(network, phase).drained + m.sync_cycles);
    }
}

TEST_CASE("Wormhole's tiles lie beside its memory, and each direction takes the network that is shorter")
{
    Grid const grid{8, 12};
    auto m = model();
    m.exchange_cost = ExchangeCost::live;
    m.network = wormhole();
    auto const nodes = nodes_of(*m.network, grid);
    CHECK(nodes[grid.index_of(TileId::at(3, 0))] == NetworkNode{4, 0});
    CHECK(nodes[grid.index_of(TileId::at(4, 2))] == NetworkNode{6, 2}); // column 5 is DRAM
    auto const cost_of = [&](std::vector<TileSample> tiles) {
        Trace trace;
        trace.kernels = {"Send"};
        trace.supersteps = {{0, false, 4, true, std::move(tiles)}};
        return model_cost(m, trace, grid).supersteps[0];
    };
    // 2,048 bytes and a head over 32 bytes a cycle take 65 cycles; to start them takes 127. There and back is once around a row of 10 nodes.
    auto const start = 10 * 9 + 270;
    CHECK(cost_of({{0, {}, {0, 2048, 0, 0}}}).exchange == 100 + 127 + start);
    CHECK(bound_text(cost_of({{0, {}, {0, 2048, 0, 0}}}), grid) == "issue 0");
    CHECK(cost_of({{1, {}, {0, 0, 2048, 0}}}).exchange == 100 + 127 + start);
    CHECK(cost_of({{0, {}, {0, 0, 0, 2048}}}).exchange == 100 + 127 + 12 * 9 + 270); // a column has 12
    // Two tiles send 8,192 bytes, 257 flits with the head, into the port of a third, one over each network: ports of their own. The links from
    // its own column are shared with nobody.
    CHECK(cost_of({{0, {}, {0, 8192, 0, 0}}, {2, {}, {0, 0, 8192, 0}}}).exchange == 100 + 257 + start);
    // A superstep in which only notes are sent has the latency.
    CHECK(cost_of({{0, {}, {}}}).exchange == 100 + 270);

    auto const refusal = [&](CostModel const& wrong, Grid other) { return error_of([&] { (void)model_cost(wrong, Trace{}, other); }); };
    CHECK(has(refusal(m, {9, 12}), "it has room for 8 x 12"));
    CHECK(has(refusal(m, {8, 13}), "it has room for 8 x 12"));
    auto both = m;
    both.chips = {2, 2, 50, 1000, "by hand"};
    CHECK(has(refusal(both, grid), "has a network and chips"));
    CHECK(has(error_of([&] { (void)exchange_network(m, {1025, 1}); }), "each side is 1 to 1,024"));
}

TEST_CASE("a grid on a part of a mesh costs what its transfers cost on all of it")
{
    support::Random random(9);
    Grid const grid{6, 4};
    auto m = model();
    m.exchange_cost = ExchangeCost::live;
    m.exchange_cycles = 7;
    auto& large = m.network.emplace();
    large.name = "large";
    large.columns = 40, large.rows = 30;
    large.link = large.flit = {4, "by hand"};
    large.port_in = {8, "by hand", 3};
    large.packet = {1000, "by hand"};
    large.hop = {1, "by hand"};
    auto const trace = random_trace(grid, random);
    auto const cost = model_cost(m, trace, grid);
    auto const nodes = nodes_of(*m.network, grid);
    std::uint32_t priced = 0;
    for (std::size_t k = 0; k < trace.supersteps.size(); ++k) {
        auto const transfers = exchange_transfers(*m.network, nodes, trace.supersteps[k], grid, m.exchange_cost);
        if (transfers.empty()) continue;
        auto const time = time_of(*m.network, transfers);
        CHECK(cost.supersteps[k].exchange == 7 + time.drained);
        CHECK(cost.supersteps[k].bound == time.bound);
        ++priced;
    }
    CHECK(priced > 4);
}

TEST_CASE("a model's file holds its network: written and read back equal, with the same cycles; bad lines are refused in one line")
{
    auto const text_of = [](CostModel const& m) {
        std::ostringstream out;
        write_cost_model(out, m);
        return out.str();
    };
    auto const read = [](std::string const& text) {
        std::istringstream in(text);
        return read_cost_model(in, "m.txt");
    };
    Grid const grid{6, 5};
    support::Random random(5);
    auto const trace = random_trace(grid, random);
    auto compiled = mk2();
    compiled.chips = {3, 2, 50, 1500, "by hand"};
    auto const from_compiled = exchange_network(compiled, grid);
    for (auto const& network : {wormhole(), blackhole(), exchange_network(mk2(), grid), from_compiled}) {
        auto m = mk2();
        m.network = network;
        m.name = network.name;
        auto const again = read(text_of(m));
        CHECK(again == m);
        CHECK(model_cost(again, trace, grid).cycles == model_cost(m, trace, grid).cycles);
        CHECK(text_of(again) == text_of(m));
    }
    CHECK(from_compiled.border.per == 3); // 1.5 cycles a byte is a rate of 2 bytes in 3 cycles
    auto at_border = mk2();
    at_border.network = from_compiled;
    CHECK(has(text_of(at_border), "network.border 2/3 "));

    auto m = mk2();
    m.network = wormhole();
    auto const whole = text_of(m);
    auto const refuses = [&](std::string const& from, std::string const& to, char const* words) {
        auto text = whole;
        auto const at = text.find('\n' + from) + 1;
        REQUIRE(at != 0);
        text.replace(at, text.find('\n', at) - at, to);
        auto const said = error_of([&] { (void)read(text); });
        INFO(said);
        CHECK(said.rfind("m.txt ", 0) == 0);
        CHECK(has(said, words));
        CHECK(said.find('\n') == std::string::npos);
    };
    refuses("network ", "network ring kind n", "has no kind of network");
    refuses("network ", "", "without \"network\"");
    refuses("network.nodes", "", "without its nodes");
    refuses("network.nodes", "network.nodes 10 nodes x", "COLUMNSxROWS");
    refuses("network.nodes", "network.nodes 0x12 nodes x", "COLUMNSxROWS");
    refuses("network.nodes", "network.nodes 10x1025 nodes x", "COLUMNSxROWS");
    refuses("network.nodes", "network.nodes 5x12 nodes x", "has a memory column 5 (the network has 5 columns");
    refuses("network.memory_columns", "network.memory_columns 0, columns x", "with commas between them");
    refuses("network.link", "network.link 4097 bytes_a_cycle x", "has no value of network.link");
    refuses("network.link", "network.link 32/0 bytes_a_cycle x", "has no value of network.link");
    refuses("network.link", "network.link 32 bytes x", "has another unit");
    refuses("network.hop", "network.hop 1/2 cycles x", "has no whole number");
    refuses("network.hop", "network.hop 1000001 cycles x", "is out of range");
    refuses("network.hop", "network.hop 9 cycles", "has no source");
    refuses("network.hop", "network.hops 9 cycles x", "use network, network.nodes");
    refuses("network.packet", "", "without its packets");
    refuses("network.hop", "network.hops 9 millicycles x", "use network, network.nodes"); // no operation has such a name

    m.network->hop.source.clear();
    CHECK(has(error_of([&] { (void)text_of(m); }), "the source of network.hop is not one line"));
    m.network = wormhole();
    m.network->sources.nodes.clear();
    CHECK(has(error_of([&] { (void)text_of(m); }), "the source of network.nodes is not one line"));
    CHECK(has(error_of([&] { set_price(m, "network.hop", 1, "x"); }), "cannot be priced"));
}

TEST_CASE("what bounds a superstep: the largest part, and of an exchange its resource")
{
    using namespace engine_test::two_supersteps;
    auto const m = model();
    auto const cost = model_cost(m, by_hand(), row);
    CHECK(bound_text(cost.supersteps[0], row) == "port in (0 0)"); // 124 cycles; all tiles are alike
    CHECK(bound_text(cost.supersteps[1], row) == "compute (2 0)"); // 12 cycles
    auto const bound = [&](std::size_t superstep, auto const& change) {
        auto changed = m;
        change(changed);
        return bound_text(model_cost(changed, by_hand(), row).supersteps[superstep], row);
    };
    CHECK(bound(0, [](CostModel& c) { c.exchange_cost = ExchangeCost::live; }) == "port in (2 0)");                               // 20 bytes go there
    CHECK(bound(0, [](CostModel& c) { c.exchange_cost = ExchangeCost::live, c.exchange_millicycles_a_byte = 0; }) == "exchange"); // 100 cycles
    CHECK(bound(0, [](CostModel& c) { c.chips = {2, 1, 500, 0, "by hand"}; }) == "border (0 0) e");
    CHECK(bound(0, [](CostModel& c) { c.sync_cycles = 1000; }) == "sync");
    CHECK(bound(1, [](CostModel& c) { c.sync_cycles = 1000, c.vote_cycles = 2000; }) == "vote");
    CHECK(bound_text(SuperstepCost{0}, row).empty());
    std::ostringstream csv;
    write_step_csv(csv, by_hand(), m, row);
    CHECK(has(csv.str(), "slowest_x,slowest_y,bound_by\n0,0,Send,3,31,124,7,0,1,0,port in (0 0)\n1,1,Take,2,12,0,7,3,2,0,compute (2 0)\n"));
}
