// test: unoptimised test asan
// The time of a phase on a network: by hand, to the cycle; against a calculation of its own; what a bound guarantees.
#include "../splat/support.hpp"
#include <tilemesh/model/network.hpp>

using namespace tilemesh;

namespace {

/// 4 x 3 nodes, one byte a cycle everywhere, no heads, no latency.
Network plain()
{
    Network n;
    n.name = "plain";
    n.columns = 4, n.rows = 3;
    n.link = n.port_in = n.port_out = {1, "by hand"};
    n.flit = {1, "by hand"};
    n.packet = {1000, "by hand"};
    return n;
}
NetworkTransfer move(NetworkNode from, NetworkNode to, std::uint64_t bytes, std::uint32_t core = 0, NetworkWay way = NetworkWay::columns_first)
{
    return {from, to, way, bytes, core};
}
NetworkTime of(Network const& n, std::vector<NetworkTransfer> const& phase) { return time_of(n, phase); }
std::string refusal(Network const& n, std::vector<NetworkTransfer> const& phase)
{
    return tests::error_of([&] { (void)time_of(n, phase); });
}
using tests::has;
std::vector<NetworkNumber> numbers_of(Network const& n)
{
    return {n.link, n.port_in, n.port_out, n.memory, n.flit, n.packet, n.head, n.hop, n.latency, n.issue, n.outstanding};
}

/// The links of a way as words, walked node by node.
std::vector<std::string> links_of(Network const& n, NetworkTransfer const& t)
{
    std::vector<std::string> out;
    std::int64_t x = t.source.x, y = t.source.y;
    bool const first = t.way == NetworkWay::columns_first;
    auto const go = [&](bool in_x) {
        while (in_x ? x != t.sink.x : y != t.sink.y) {
            bool const up = n.torus ? first : (in_x ? t.sink.x > x : t.sink.y > y);
            out.push_back((first ? "0 " : "1 ") + std::to_string(x) + " " + std::to_string(y) + (in_x ? (up ? " e" : " w") : (up ? " s" : " n")));
            (in_x ? x : y) += up ? 1 : -1;
            x = (x + n.columns) % n.columns;
            y = (y + n.rows) % n.rows;
        }
    };
    go(first);
    go(!first);
    return out;
}
/// The same times by long double and maps of names. It shares nothing with the library.
std::tuple<long double, long double, long double> by_names(Network const& n, std::vector<NetworkTransfer> const& phase)
{
    std::map<std::string, std::set<std::string>> sources;
    auto const name = [](NetworkNode const& at) { return std::to_string(at.x) + "," + std::to_string(at.y); };
    long double way = 0;
    for (auto const& t : phase) {
        for (auto const& link : links_of(n, t)) sources[link].insert(name(t.source));
        auto back = t;
        back.source = t.sink, back.sink = t.source;
        way = std::max(way, static_cast<long double>(links_of(n, t).size() + links_of(n, back).size()));
    }
    auto const busiest = [&](std::vector<NetworkTransfer> const& some, bool issue, bool meeting) {
        std::map<std::string, long double> load;
        for (auto const& t : some) {
            auto const up = [](std::uint64_t a, std::uint64_t b) { return static_cast<long double>((a + b - 1) / b); };
            long double const packets = up(t.bytes, n.packet.value);
            long double const bytes = up(t.bytes, n.flit.value) * static_cast<long double>(n.flit.value) + packets * static_cast<long double>(n.head.value);
            auto const add = [&](std::string const& what, NetworkNumber const& rate, long double more) {
                if (rate.value != 0) load[what] += bytes * static_cast<long double>(rate.per) / static_cast<long double>(rate.value) + more;
            };
            std::string const net = t.way == NetworkWay::columns_first ? "0 " : "1 ";
            add("out " + net + name(t.source), n.port_out, 0);
            add("in " + net + name(t.sink), n.port_in, 0);
            bool const memory = std::count(n.memory_columns.begin(), n.memory_columns.end(), t.source.x) != 0;
            if (memory) add("memory " + name(t.source), n.memory, 0);
            for (auto const& link : links_of(n, t))
                add("link " + link, n.link, meeting && memory && sources[link].size() > 2 ? packets * static_cast<long double>(n.hop.value) : 0);
            // Of each border that the way crosses, from chip to chip: the bytes, and once its cycles.
            std::int64_t x = t.source.x, y = t.source.y;
            for (auto const& link : links_of(n, t)) {
                if (n.chip_columns == 0) break;
                auto const chip = [&] { return std::to_string(x / n.chip_columns) + "," + std::to_string(y / n.chip_rows); };
                auto const before = chip();
                char const side = link.back();
                x = (x + (side == 'e' ? 1 : side == 'w' ? -1 : 0) + n.columns) % n.columns;
                y = (y + (side == 's' ? 1 : side == 'n' ? -1 : 0) + n.rows) % n.rows;
                if (chip() == before || n.border.value == 0) continue;
                auto const border = "border " + before + side;
                if (load.count(border) == 0) load[border] = static_cast<long double>(n.crossing.value);
                add(border, n.border, 0);
            }
            if (issue) load["core " + std::to_string(t.core)] += static_cast<long double>(n.issue.value);
        }
        long double most = 0;
        for (auto const& [what, cycles] : load) most = std::max(most, cycles);
        return most;
    };
    std::map<std::uint32_t, std::uint64_t> number;
    std::map<std::uint64_t, std::vector<NetworkTransfer>> rounds;
    for (auto const& t : phase) {
        auto const k = number[t.core]++;
        rounds[n.outstanding.value == 0 ? 0 : k / n.outstanding.value].push_back(t);
    }
    long double drained = 0;
    for (auto const& [k, round] : rounds) drained += busiest(round, true, true);
    long double const start = way * static_cast<long double>(n.hop.value) + static_cast<long double>(n.latency.value);
    return {busiest(phase, false, false), busiest(phase, true, false) + start, drained + start};
}
bool equal(std::uint64_t cycles, long double exact) { return std::fabs(static_cast<long double>(cycles) - std::ceil(exact - 1e-6L)) < 0.5L; }

std::vector<NetworkTransfer> random_phase(Network const& n, support::Random& random, std::uint32_t transfers)
{
    std::vector<NetworkTransfer> phase;
    for (std::uint32_t i = 0; i < transfers; ++i)
        phase.push_back({{random.below(n.columns), random.below(n.rows)},
                         {random.below(n.columns), random.below(n.rows)},
                         random.below(2) == 0 ? NetworkWay::columns_first : NetworkWay::rows_first,
                         random.below(5) == 0 ? 1 + random.below(40'000) : 64 * (1 + random.below(64)),
                         random.below(1 + random.below(20))});
    return phase;
}

} // namespace

TEST_CASE("a phase by hand: ports, links, memory, issue, rounds, hops")
{
    auto n = plain();
    auto const one = of(n, {move({0, 0}, {2, 1}, 100)});
    CHECK(one.at_least == 100);
    CHECK(one.drained == 100);
    CHECK(one.bound == NetworkResource{NetworkResource::port_out, {0, 0}, ' '}); // the first of equals
    // Two transfers share the link (1, 0) east, and no port.
    std::vector<NetworkTransfer> const shared{move({0, 0}, {2, 1}, 100), move({1, 0}, {3, 0}, 70, 1)};
    CHECK(of(n, shared).at_least == 170);
    CHECK(of(n, shared).bound == NetworkResource{NetworkResource::link, {1, 0}, 'e'});
    // Rows first, they part.
    auto apart = shared;
    apart[0].way = NetworkWay::rows_first;
    CHECK(of(n, apart).at_least == 100);
    // A mesh goes the short way, a torus its one way round.
    CHECK(of(n, {move({3, 0}, {0, 0}, 10)}).loaded == 10);
    n.hop = {5, "by hand"};
    n.latency = {7, "by hand"};
    CHECK(of(n, {move({3, 0}, {0, 0}, 10)}).loaded == 10 + 7 + 5 * 6); // three links there and three back
    n.torus = true;
    CHECK(of(n, {move({3, 0}, {0, 0}, 10)}).loaded == 10 + 7 + 5 * 4); // one there, three back
    // Issue: a core starts one transfer in 40 cycles.
    n = plain();
    n.issue = {40, "by hand"};
    std::vector<NetworkTransfer> few(5, move({0, 0}, {1, 0}, 3));
    CHECK(of(n, few).at_least == 15);
    CHECK(of(n, few).loaded == 200);
    CHECK(of(n, few).bound == NetworkResource{NetworkResource::issue, {0, 0}, ' '});
    few[1].core = few[3].core = 1;
    CHECK(of(n, few).loaded == 120);
    // Rounds: two cores alternate between two ports, so that every round of one has only half of each.
    n.issue = {0, "by hand"};
    std::vector<NetworkTransfer> turns;
    for (std::uint32_t i = 0; i < 4; ++i)
        for (std::uint32_t core = 0; core < 2; ++core) turns.push_back(move({0, core}, {i % 2 == 0 ? 3u : 1u, 2}, 10, core));
    CHECK(of(n, turns).drained == 40);
    n.outstanding = {1, "by hand"};
    CHECK(of(n, turns).drained == 80); // each round, both go into one port
    n.outstanding = {2, "by hand"};
    CHECK(of(n, turns).drained == 40);
    // Memory: 3 bytes in two cycles are not whole cycles; sums are exact, and rounded up once.
    n = plain();
    n.memory_columns = {0};
    n.memory = {24, "by hand"};
    n.port_in = n.port_out = n.link = {32, "by hand"};
    n.flit = {32, "by hand"};
    CHECK(of(n, {move({0, 0}, {1, 0}, 32), move({0, 0}, {1, 0}, 1)}).at_least == 3); // 64 / 24
    CHECK(of(n, {move({1, 0}, {2, 0}, 32), move({1, 0}, {2, 0}, 1)}).at_least == 2); // 64 / 32
    // A packet has a head; answers of three memory channels on one link wait one more hop each.
    n.head = {32, "by hand"};
    n.packet = {64, "by hand"};
    n.hop = {9, "by hand"};
    CHECK(of(n, {move({1, 0}, {1, 1}, 128)}).at_least == 6);
    n.memory_columns = {0, 1, 2};
    std::vector<NetworkTransfer> meet{move({0, 0}, {3, 0}, 64), move({1, 0}, {3, 0}, 64, 1)};
    auto const start = 9 * (3 + 3);
    CHECK(of(n, meet).drained == 6 + start);
    meet.push_back(move({2, 0}, {3, 0}, 64, 2));
    CHECK(of(n, meet).drained == 9 + 3 * 9 + start);
    CHECK(of(n, meet).loaded == 9 + start);
    n.memory_columns = {0, 1}; // two of three wait
    CHECK(of(n, meet).drained == 9 + 2 * 9 + start);
}

TEST_CASE("random phases: an independent calculation, to the cycle; and the bound is never above the prediction")
{
    support::Random random(31);
    for (std::uint32_t i = 0; i < 150; ++i) {
        auto n = i % 3 == 0 ? wormhole() : plain();
        if (i % 3 != 0) {
            n.torus = random.below(2) == 0;
            n.columns = 1 + random.below(6), n.rows = 1 + random.below(6);
            n.memory_columns = {random.below(n.columns)};
            n.link.value = 1 + random.below(64), n.memory.value = random.below(64);
            n.port_in.value = random.below(64), n.port_out.value = random.below(64), n.port_in.per = 1 + random.below(3);
            n.chip_columns = random.below(4), n.chip_rows = n.chip_columns == 0 ? 0 : 1 + random.below(3);
            n.border.value = random.below(30), n.crossing.value = random.below(200);
            n.flit.value = 1 + random.below(64), n.packet.value = 1 + random.below(4096), n.head.value = random.below(64);
            n.hop.value = random.below(20), n.issue.value = random.below(300), n.latency.value = random.below(500);
            n.outstanding.value = random.below(9);
        }
        auto const phase = random_phase(n, random, 1 + random.below(60));
        auto const time = time_of(n, phase);
        auto const [at_least, loaded, drained] = by_names(n, phase);
        INFO("phase ", i);
        CHECK(equal(time.at_least, at_least));
        CHECK(equal(time.loaded, loaded));
        CHECK(equal(time.drained, drained));
        CHECK(time.at_least <= time.loaded);
        CHECK(time.loaded <= time.drained);
        auto more = phase; // a further transfer never makes a phase shorter
        more.push_back(random_phase(n, random, 1)[0]);
        CHECK(time_of(n, more).at_least >= time.at_least);
        CHECK(time_of(n, more).loaded >= time.loaded);
    }
}

TEST_CASE("a network that cannot be, and a transfer outside it, are refused")
{
    auto const good = std::vector{move({0, 0}, {1, 1}, 8)};
    CHECK(refusal(plain(), good).empty());
    CHECK(has(refusal(plain(), {}), "a phase without transfers"));
    CHECK(has(refusal(plain(), {move({4, 0}, {0, 0}, 1)}), "(4, 0)"));
    CHECK(has(refusal(plain(), {move({0, 0}, {0, 3}, 1)}), "(0, 3)"));
    CHECK(has(refusal(plain(), {move({0, 0}, {1, 0}, (std::uint64_t{1} << 30) + 1)}), "2^30"));
    CHECK(refusal(plain(), {move({0, 0}, {1, 0}, std::uint64_t{1} << 30)}).empty());
    CHECK(refusal(plain(), {move({0, 0}, {1, 0}, 0)}).empty());
    auto const refuses = [&](char const* words, auto const& change) {
        auto bad = plain();
        change(bad);
        CHECK(has(refusal(bad, good), words));
    };
    refuses("each side is 1 to 1,024", [](Network& n) { n.columns = 0; });
    refuses("0 bytes", [](Network& n) { n.flit.value = 0; });
    refuses("at most 1,000,000", [](Network& n) { n.hop.value = 1'000'001; });
    refuses("at most 10^12", [](Network& n) { n.latency.value = 1'000'000'000'001; });
    refuses("give both sides", [](Network& n) { n.chip_rows = 2; });
    refuses("at most 4,096", [](Network& n) { n.link.value = 4097; });
    auto bad = plain();
    bad.link.value = 4093, bad.port_in.value = 4091, bad.memory.value = 4079; // primes
    CHECK(has(refusal(bad, {move({0, 0}, {1, 0}, std::uint64_t{1} << 30)}), "do not fit 64 bits"));
    for (auto const& number : numbers_of(wormhole())) {
        bool const says = number.source.starts_with("document: ") || number.source.starts_with("measured by others: ") || number.source.starts_with("fitted: ");
        CHECK(says);
    }
}

TEST_CASE("blackhole has documented numbers alone, and none that is fitted or measured")
{
    auto const n = blackhole();
    for (auto const& number : numbers_of(n)) {
        bool const says = number.value == 0 ? number.source.starts_with("guess: ") : number.source.starts_with("document: ");
        CHECK(says);
    }
    // Four writes of 1 KiB to the next core: 16 flits and a head each. The way there and back is once around a column.
    std::vector<NetworkTransfer> const four(4, move({1, 2}, {1, 3}, 1024));
    CHECK(of(n, four).at_least == 4 * 17);
    CHECK(of(n, four).drained == 4 * 17 + 12 * 9 + 20);
    CHECK(of(n, four).loaded == of(n, four).drained);
    CHECK(of(n, {move({1, 2}, {1, 3}, 16384)}).at_least == 257); // one packet
    CHECK(of(n, {move({1, 2}, {1, 3}, 16385)}).at_least == 259); // two, and one more flit
}
