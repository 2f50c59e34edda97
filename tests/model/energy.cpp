// test: unoptimised test asan, without tsan
#include "model_by_hand.hpp"
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/model/energy.hpp>
#include <tilemesh/model/energy_range.hpp>

// Energy: an example computed by hand, exact sums, refusals of events without an energy, and the file.
using namespace tilemesh;
using engine_test::two_supersteps::by_hand;
using engine_test::model;
using engine_test::two_supersteps::row;

namespace {
constexpr std::uint64_t cycles[] = {31 + 124 + 7, 12 + 7 + 3};

EnergyModel prices()
{
    EnergyModel e;
    e.name = "by hand";
    set_energy(e, "slot", 1000, "a test");
    set_energy(e, "routed", 20'000, "a test");
    set_energy(e, "capacity_byte", 10, "a test");
    set_energy(e, "tile_cycle", 3, "a test");
    return e;
}
using tests::error_of;
EnergyModel read(std::string const& text)
{
    std::istringstream in(text);
    return read_energy_model(in, "energy.txt");
}
double femto(std::uint64_t n)
{
    return static_cast<double>(n) / 1e15;
}
} // namespace

TEST_CASE("energy: power x time")
{
    auto m = model(); // 1,000 kHz
    CHECK(joules_of_power(m, 1'000'000, 27.18) == 27.18);
    CHECK(joules_of_power(m, 0, 27.18) == 0);
    CHECK(joules_of_power(m, 500'000, 0) == 0);
    CHECK(joules_of_power(m, 250'000, 20) == 5);
    for (double watts : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()})
        CHECK_THROWS_AS(joules_of_power(m, 1, watts), Error);
    m.clock_khz = 0;
    CHECK(error_of([&] { joules_of_power(m, 1, 2); }).starts_with("energy cannot be computed (model \"by hand\" has a clock of 0 kHz"));
}

TEST_CASE("energy: three tiles and two steps, by hand")
{
    auto const e = energy_of(prices(), model(), by_hand(), row);
    CHECK(e.of("slot").count == 12);
    CHECK(e.of("routed").count == 4);
    CHECK(e.of(sent_byte_event).count == 0); // these bytes are in the copies
    CHECK(e.of(capacity_byte_event).count == 3 * 4 * 24);
    CHECK(e.of(tile_cycle_event).count == 3 * (cycles[0] + cycles[1]));
    CHECK(e.of("slot").joules == femto(12'000));
    CHECK(e.of("routed").joules == femto(80'000));
    CHECK(e.of(capacity_byte_event).joules == femto(2'880));
    CHECK(e.of(tile_cycle_event).joules == femto(9 * (cycles[0] + cycles[1])));
    CHECK(e.joules_of_step == std::vector<double>{femto(8'000 + 80'000 + 2'880 + 9 * cycles[0]), femto(4'000 + 9 * cycles[1])});
    auto const alike = 960 + 3 * (cycles[0] + cycles[1]);
    CHECK(e.joules_of_tile == std::vector<double>{femto(22'000 + alike), femto(67'000 + alike), femto(3'000 + alike)});
    CHECK(e.joules == femto(12'000 + 80'000 + 2'880 + 9 * (cycles[0] + cycles[1])));

    // Live bytes instead of copies: 20 received at most, 5 cycles.
    auto live = model();
    live.exchange_cost = ExchangeCost::live;
    auto priced = prices();
    set_energy(priced, "sent_byte", 100, "a test");
    auto const l = energy_of(priced, live, by_hand(), row);
    CHECK(l.of(capacity_byte_event).count == 0);
    CHECK(l.of(sent_byte_event).count == 32);
    CHECK(l.of(sent_byte_event).joules == femto(3'200));
    CHECK(l.of(tile_cycle_event).count == 3 * (31 + 105 + 7 + 22));
    CHECK(l.joules_of_tile[2] == femto(3'000 + 3 * 165));
}

TEST_CASE("energy: an event without an energy is refused; an event that does not occur needs none")
{
    auto e = prices();
    std::erase_if(e.events, [](ModelParameter const& p) { return p.name == "routed"; });
    CHECK(error_of([&] { energy_of(e, model(), by_hand(), row); }) ==
          "energy model \"by hand\" cannot be applied (event routed occurs, first in superstep 0, and its energy is not set); set it, "
          "and say where it is from");
    auto quiet = by_hand();
    for (auto& s : quiet.supersteps)
        for (auto& t : s.tiles) t.operations[2] = 0; // routed;
    CHECK(energy_of(e, model(), quiet, row).of("routed").count == 0);
    auto live = model();
    live.exchange_cost = ExchangeCost::live;
    CHECK(error_of([&] { energy_of(prices(), live, by_hand(), row); }).find("event sent_byte occurs") != std::string::npos);
    // A new model has no energies. A free event needs an energy of 0.
    CHECK_THROWS_AS(energy_of({}, model(), by_hand(), row), Error);
    set_energy(e, "routed", 0, "not counted: part of slot");
    CHECK(energy_of(e, model(), by_hand(), row).of("routed").joules == 0);
    // Nothing ran, nothing is needed.
    Trace none;
    CHECK(energy_of({}, model(), none, row).joules == 0);
    CHECK(energy_of({}, model(), none, row).joules_of_tile == std::vector<double>(3, 0.0));

    CHECK(error_of([] { energy_of(prices(), model(), by_hand(), {2, 1}); }).find("the trace and the grid of one run") != std::string::npos);
}

TEST_CASE("energy: sums are exact where 64 bits would not hold them, and counts above 64 bits are refused")
{
    model_detail::Femtojoules sum;
    sum.add(0xffffffffffffffffu, 4'000'000'000u);
    CHECK(sum.high == 3'999'999'999u); // 2^64 * 4e9 - 4e9
    CHECK(sum.low == std::uint64_t{0} - 4'000'000'000u);
    sum.add(4'000'000'000u);
    CHECK(sum.high == 4'000'000'000u);
    CHECK(sum.low == 0);
    CHECK(sum.joules() == 4e9 * 18446744073709551616.0 / 1e15);

    auto slow = model();
    slow.sync_cycles = most_cycles;
    Trace trace;
    trace.kernels = {"K"};
    trace.supersteps.assign(20, {0, false, 0, false, {}});
    auto const e = energy_of(prices(), slow, trace, {1000, 800});
    CHECK(e.of(tile_cycle_event).count == 20 * most_cycles * 800'000);
    CHECK(e.joules_of_tile[799'999] == 20 * 1e12 * 3 / 1e15);
    trace.supersteps.assign(24, {0, false, 0, false, {}});
    CHECK(error_of([&] { energy_of(prices(), slow, trace, {1000, 800}); }) ==
          "energy cannot be computed (more than 2^64 of event tile_cycle); model a shorter run");
}

TEST_CASE("energy: by kind, by step and by tile are the same joules")
{
    auto const e = energy_of(prices(), model(), by_hand(), row);
    std::vector<double> of_events;
    for (auto const& event : e.events) of_events.push_back(event.joules);
    for (auto const& parts : {of_events, e.joules_of_step, e.joules_of_tile})
        CHECK(std::accumulate(parts.begin(), parts.end(), 0.0) == doctest::Approx(e.joules).epsilon(1e-14));
}

TEST_CASE("energy: invalid names, values and sources are refused")
{
    EnergyModel e;
    for (std::string const name : {"", "#slot", "two words", "caf\xc3\xa9"})
        CHECK(error_of([&] { set_energy(e, name, 1, "x"); }).find("an event is a word of 1 to 64 printable ASCII characters") != std::string::npos);
    CHECK(error_of([&] { set_energy(e, "slot", most_femtojoules + 1, "x"); }) ==
          "parameter slot cannot be 4000000001 (it goes from 0 to 4000000000 fJ); give it a value in this range");
    auto by_hand_set = prices(); // events are public: values that set_energy refuses would wrap in the sums
    for (std::uint64_t const value : {most_femtojoules + 1, std::uint64_t{1} << 32, ~std::uint64_t{0}}) {
        by_hand_set.events[0].value = value;
        CHECK(error_of([&] { energy_of(by_hand_set, model(), by_hand(), row); }) ==
              "parameter slot cannot be " + std::to_string(value) + " (it goes from 0 to 4000000000 fJ); give it a value in this range");
    }
    by_hand_set.events[0].value = most_femtojoules;
    CHECK(energy_of(by_hand_set, model(), by_hand(), row).of("slot").joules == femto(12 * most_femtojoules));
    for (std::string const source : {"", " x", "x ", "a\nb"}) CHECK_THROWS_AS(set_energy(e, "slot", 1, source), Error);
    CHECK(e == EnergyModel{});
    set_energy(e, "slot", most_femtojoules, "x");
    set_energy(e, "slot", 2, "y");
    CHECK(e.events[0].value == 2);
    CHECK(e.events[0].source == "y");
}

TEST_CASE("energy: the file")
{
    CHECK(read("# a test\nenergy by hand\nslot 1000 fJ a test\ncapacity_byte 10 fJ a test\nrouted   20000   fJ   a test\n"
               "tile_cycle 3 fJ a test\n")
              .events.size() == 4);
    CHECK(read("energy x\n# nothing is known\n").events.empty());
    CHECK(read("energy x\nslot 5 fJ\ta paper\n").events[0].source == "a paper");

    auto const begins = [](std::string const& file, std::string const& start) {
        auto const error = error_of([&] { read(file); });
        CAPTURE(error);
        CHECK(error.starts_with("energy.txt line " + start));
    };
    begins("", "0 ends the file (it holds no energy model); begin it with \"energy NAME\"");
    begins("model m\n", "1 begins no energy model");
    begins("energy m\ntile_cycle 1 pJ x\n", "2 has another unit (tile_cycle is in fJ, not in \"pJ\"); convert the value");
    begins("energy m\nslot 1 pJ x\n", "2 has another unit (slot is in fJ, not in \"pJ\"); convert the value");
    begins("energy m\nslot 1 W x\n", "2 has an unknown parameter (\"slot\"); use sent_byte, capacity_byte, tile_cycle, or the name of an operation and the unit fJ");
    CHECK(read("energy m\nswap 1 fJ x\n").events[0].name == "swap"); // an operation of a user's program
    begins("energy m\nslot 1 fJ\n", "2 has no source");
    begins("energy m\nslot 1.5 fJ x\n", "2 has no whole number (slot is \"1.5\"); write digits only, from 0 to 4000000000");
    begins("energy m\nslot 4000000001 fJ x\n", "2 is out of range");
    begins("energy m\nslot 1 fJ x\nslot 1 fJ x\n", "3 repeats a parameter (slot is in line 2)");
    begins("energy m\nclock 1 kHz x\n", "2 has an unknown parameter");
    begins("energy m\n#" + std::string(4096, '.'), "2 is too long (more than 4096 bytes); shorten its source, or name an energy model");
}

TEST_CASE("energy: Mk2's range has an energy for each of its operations, with a source, and an answer is a range")
{
    auto const range = mk2_energies();
    for (auto const* e : {&range.least, &range.most}) {
        CHECK(e->events.size() == mk2().prices.size() + 3);
        for (auto const& p : e->events) {
            CAPTURE(p.name);
            // What no source has is 0, never a number.
            CHECK((p.kind == PriceKind::documented || (p.kind == PriceKind::guessed && p.value == 0)));
        }
    }
    auto const of = [](EnergyModel const& e, char const* name) {
        return std::find_if(e.events.begin(), e.events.end(), [name](auto const& p) { return p.name == name; })->value;
    };
    CHECK(of(range.least, "pair") == 13'755);        // 21 flops, 10.5 multiplications of 1.31 pJ
    CHECK(of(range.least, "projection") == 189'295); // 289 flops
    CHECK(of(range.least, "slot") == 0);
    CHECK(of(range.least, "sent_byte") == 150);
    CHECK(of(range.most, "tile_cycle") == 94'853); // 185 W / 1,472 / 1.325 GHz
    // Three tiles, two supersteps: 4 * 24 bytes of capacity a tile; and every tile's cycles.
    auto const joules = joules_range(range, model(), by_hand(), row);
    CHECK(joules.least == femto(3 * 96 * 150));
    CHECK(joules.most == femto(3 * (cycles[0] + cycles[1]) * 94'853));
}
