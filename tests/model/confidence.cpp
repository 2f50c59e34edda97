// test: unoptimised test asan
// What a modelled total rests on: the kinds of prices by their sources; a run's cycles by kind, by hand; every number of mk2().
#include "../engine/everywhere.hpp"
#include "model_by_hand.hpp"
#include <tilemesh/model/assumed_parameters.hpp>
#include <tilemesh/model/chips.hpp>
#include <tilemesh/model/confidence.hpp>
#include <tilemesh/model/cost_parameters.hpp>

using namespace tilemesh;
using engine_test::error_of;
using engine_test::has;
using namespace engine_test::two_supersteps;

namespace confidence_test {
struct Other {
    static constexpr char const* name = "other";
    static constexpr std::uint32_t tiles = 9, sram_bytes = 1024, code_bytes = 0, workers = 3, clock_khz = 7;
};
} // namespace confidence_test

namespace {

using confidence_test::Other;

/// The model of model_by_hand.hpp with sources.
CostModel sourced()
{
    auto m = engine_test::model();
    auto const prices = m.prices;
    for (auto const& p : prices) set_price(m, p.operation, p.millicycles, "guess: it does not occur");
    set_price(m, "slot", 500, "document: a");
    set_price(m, "routed", 6000, "fitted to b");
    set_parameter(m, "run", 10, "document: c");
    set_parameter(m, "exchange", 100, "measured by others: d");
    set_parameter(m, "exchange_byte", 250, "document: e");
    set_parameter(m, "sync", 7, "arithmetic: f");
    set_parameter(m, "vote", 3, "fitted to g");
    return m;
}
std::uint64_t of(Confidence const& c, PriceKind kind) { return c.cycles[static_cast<std::size_t>(kind)]; }

} // namespace

TEST_CASE("a source's first word says the kind, and a guess anywhere makes it one")
{
    for (auto const& each : {std::pair("document: a guide", PriceKind::documented), {"measured by others: a trace", PriceKind::measured},
                                       {"arithmetic: 3 x 4", PriceKind::counted}, {"counted in our code", PriceKind::counted},
                                       {"fitted to Salad", PriceKind::fitted}, {"assumed", PriceKind::guessed}, {"a colleague", PriceKind::guessed},
                                       {"document: a guide; that it is 4 hops is a guess", PriceKind::guessed}, {"", PriceKind::guessed}})
        CHECK_MESSAGE(kind_of_source(each.first) == each.second, each.first);
    CHECK(ModelParameter{"sync", 7, "cycles", "fitted to x"}.kind == PriceKind::fitted);
}

TEST_CASE("the cycles of two supersteps by kind, by hand")
{
    auto const m = sourced();
    auto const cost = model_cost(m, by_hand(), row);
    REQUIRE(cost.cycles == 184);
    auto const c = confidence_of(m, by_hand(), cost);
    CHECK(of(c, PriceKind::documented) == 3 + 1 + 10 + 11 + 24); // slots, whole cycles; to start, with what rounding adds; bytes
    CHECK(of(c, PriceKind::measured) == 100);
    CHECK(of(c, PriceKind::counted) == 2 * 7);
    CHECK(of(c, PriceKind::fitted) == 18 + 3);
    CHECK(of(c, PriceKind::guessed) == 0); // such prices are of operations that do not occur
    CHECK(c.weakest == PriceKind::fitted);
    CHECK(c.names == std::vector<std::string>{"routed", "vote"}); // the most cycles first
    CHECK(confidence_text(m, by_hand(), cost) == "The weakest prices behind this time are fitted: routed, vote. They make 11.4 % of its cycles.");

    auto guessed = m;
    set_parameter(guessed, "vote", 3, "guess: h");
    CHECK(confidence_text(guessed, by_hand(), cost) == "The weakest prices behind this time are guessed: vote. They make 1.6 % of its cycles.");

    auto const none = engine_test::model(); // numbers without any source
    CHECK(of(confidence_of(none, by_hand(), cost), PriceKind::guessed) == 184);
    auto other = cost;
    other.supersteps.pop_back();
    CHECK(has(error_of([&] { (void)confidence_of(m, by_hand(), other); }), "its cost has 1 supersteps, its trace 2"));
    CHECK(confidence_text(m, Trace{}, {}).empty());
}

TEST_CASE("borders between chips are a guess, and an assumed machine rests on guesses")
{
    auto m = sourced();
    m.chips = {1, 1, 50, 1000, "by hand"};
    auto const cost = model_cost(m, by_hand(), row);
    auto const c = confidence_of(m, by_hand(), cost);
    CHECK(of(c, PriceKind::guessed) == cost.cycles - 184);
    CHECK(c.names == std::vector<std::string>{"borders between chips"});
    CHECK(std::accumulate(c.cycles.begin(), c.cycles.end(), std::uint64_t{0}) == cost.cycles);

    auto const assumed = assumed_model<Other>(32, 40);
    CHECK(assumed.name == "other, assumed");
    CHECK(confidence_of(assumed, by_hand(), model_cost(assumed, by_hand(), row)).weakest == PriceKind::guessed);
}

TEST_CASE("an exchange on a network is known as well as the network's weakest number")
{
    CHECK(kind_of_network(wormhole()) == PriceKind::fitted); // issue, outstanding
    CHECK(kind_of_network(blackhole()) == PriceKind::documented); // guesses of 0 are left out
    auto m = sourced();
    set_parameter(m, "exchange_cost", 1, "document: live");
    m.network = blackhole();
    auto const cost = model_cost(m, by_hand(), row);
    auto const c = confidence_of(m, by_hand(), cost);
    CHECK(of(c, PriceKind::documented) == 3 + 1 + 10 + 11 + cost.supersteps[0].exchange - 100);
    CHECK(of(c, PriceKind::fitted) == 18 + 3);
    m.network = wormhole();
    auto const fitted = model_cost(m, by_hand(), row);
    CHECK(of(confidence_of(m, by_hand(), fitted), PriceKind::fitted) == 18 + 3 + fitted.supersteps[0].exchange - 100);
    CHECK(confidence_of(m, by_hand(), fitted).names.front() == "network");
}

TEST_CASE("every number of mk2 has the kind that the table of include/tilemesh/model/README.md says")
{
    std::map<PriceKind, std::string> names;
    auto const m = mk2();
    for (auto const& p : m.parameters) (names[p.kind] += names[p.kind].empty() ? "" : ", ") += p.name;
    CHECK(names[PriceKind::documented] == "clock, exchange_cost, host_byte, run, exchange_byte");
    CHECK(names[PriceKind::measured].empty());
    CHECK(names[PriceKind::counted] == "slot, projection, copied, comparison, pair, pixel, left, passed, settled, moving_pair, moving_depth, "
                                        "splat_motions, row, mean, gradient");
    CHECK(names[PriceKind::fitted].empty());
    CHECK(names[PriceKind::guessed] == "routed, exchange, sync, vote");
    // A file keeps the kinds, because it keeps the sources.
    std::stringstream file;
    write_cost_model(file, m);
    CHECK(read_cost_model(file, "file") == m);
}
