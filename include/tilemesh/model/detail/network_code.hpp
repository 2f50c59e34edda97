#pragma once
#include <algorithm>
#include <cstddef>
#include <map>
#include <numeric>
#include <tilemesh/model/network.hpp>

namespace tilemesh { inline namespace v0_2 {

TILEMESH_HOST Network wormhole()
{
    std::string const isa = "document: Tenstorrent's ISA documentation, WormholeB0, NoC";
    Network n;
    n.name = "Wormhole";
    n.columns = 10, n.rows = 12;
    n.torus = true;
    n.memory_columns = {0, 5};
    n.sources = {isa + ": 10 x 12 nodes", isa + ": DRAM lies in columns 0 and 5", ""};
    n.link = {32, isa + ": a link carries a flit of 32 bytes a cycle"};
    n.port_in = n.port_out = {32, isa + ": as a link"};
    n.memory = {24, isa + ": a DRAM channel"};
    n.flit = {32, isa};
    n.packet = {8192, isa + ": a packet holds up to 256 flits"};
    n.head = {32, isa + ": one flit"};
    n.hop = {9, isa + ": a router takes 9 cycles"};
    n.latency = {270, "measured by others: tt-npe's device model, until the first byte of a read across the chip"};
    n.issue = {127, "fitted: one trace of one core, DRAM_TO_1x1"};
    n.outstanding = {6, "fitted: the best of 1 to 24 over 36 traces"};
    return n;
}

TILEMESH_HOST Network blackhole()
{
    std::string const isa = "document: Tenstorrent's ISA documentation, BlackholeA0, NoC", none = "guess: no document has it, so 0 leaves it out";
    Network n;
    n.name = "Blackhole";
    n.columns = 17, n.rows = 12;
    n.torus = true;
    n.memory_columns = {0, 9};
    n.sources = {isa + ": 17 x 12 nodes", isa + ": DRAM lies in columns 0 and 9", ""};
    n.link = {64, isa + ": a link carries a flit of 64 bytes a cycle"};
    n.port_in = n.port_out = {64, isa + ": as a link"};
    n.memory = {0, none};
    n.flit = {64, isa};
    n.packet = {16384, isa + ": a packet holds up to 256 flits"};
    n.head = {64, isa + ": one flit"};
    n.hop = {9, isa + ": a router takes 9 cycles"};
    n.latency = {20, isa + ": about 5 cycles between a core and its router, twice for the request and twice for the answer"};
    n.issue = {0, none};
    n.outstanding = {0, none};
    return n;
}

namespace model_detail {

/// Loads of all resources of a network, in units of a cycle over `scale`.
class NetworkLoads {
public:
    explicit NetworkLoads(Network const& network) : n_(network), nodes_(std::size_t{network.columns} * network.rows)
    {
        for (auto const* rate : {&n_.link, &n_.port_in, &n_.port_out, &n_.memory, &n_.border})
            if (rate->value != 0) scale_ = std::lcm(scale_, rate->value);
        for (auto const column : n_.memory_columns) memory_.push_back(column);
        if (n_.chip_columns != 0) chips_across_ = (n_.columns + n_.chip_columns - 1) / n_.chip_columns;
        std::size_t const chips = n_.chip_columns == 0 ? 0 : std::size_t{chips_across_} * ((n_.rows + n_.chip_rows - 1) / n_.chip_rows);
        load_.resize(nodes_ * per_node + 4 * chips);
        met_.resize(2 * 4 * nodes_);
    }
    std::uint64_t scale() const noexcept { return scale_; }

    /// Notes the source of a transfer on its links.
    void meet(NetworkTransfer const& t)
    {
        auto const source = static_cast<std::uint32_t>(node(t.source)) + 1;
        along(t, [&](std::size_t link, NetworkNode, NetworkNode) {
            auto& seen = met_[link];
            for (std::uint32_t& s : seen.sources) {
                if (s == source) return;
                if (s == 0) {
                    s = source;
                    return;
                }
            }
        });
    }
    /// Adds a transfer. `meeting`: with the hops where answers of memory channels meet.
    void add(NetworkTransfer const& t, bool meeting)
    {
        std::uint64_t const packets = (t.bytes + n_.packet.value - 1) / n_.packet.value;
        std::uint64_t const bytes = (t.bytes + n_.flit.value - 1) / n_.flit.value * n_.flit.value + n_.head.value * packets;
        std::size_t const way = t.way == NetworkWay::columns_first ? 0 : 1;
        auto const take = [&](std::size_t at, NetworkNumber const& rate, std::uint64_t cycles, std::uint64_t once = 0) {
            if (rate.value == 0) return;
            if (load_[at] == 0) {
                used_.push_back(at);
                load_[at] = once * scale_;
            }
            load_[at] += bytes * rate.per * (scale_ / rate.value) + cycles * scale_;
        };
        take((0 + way) * nodes_ + node(t.source), n_.port_out, 0);
        take((2 + way) * nodes_ + node(t.sink), n_.port_in, 0);
        bool const from_memory = std::find(memory_.begin(), memory_.end(), t.source.x) != memory_.end();
        if (from_memory) take(4 * nodes_ + node(t.source), n_.memory, 0);
        along(t, [&](std::size_t link, NetworkNode from, NetworkNode to) {
            bool const waits = meeting && from_memory && met_[link].sources[2] != 0;
            take(5 * nodes_ + link, n_.link, waits ? n_.hop.value * packets : 0);
            if (n_.chip_columns != 0 && chip_of(from) != chip_of(to))
                take(13 * nodes_ + 4 * chip_of(from) + link % 4, n_.border, 0, n_.crossing.value);
        });
        issues_[t.core] += n_.issue.value * scale_;
    }
    struct Most {
        std::uint64_t load;
        NetworkResource resource;
    };
    /// The busiest resource; the first of several, in the order of the kinds.
    Most most(bool with_issue) const
    {
        Most m{0, {}};
        auto used = used_;
        std::sort(used.begin(), used.end());
        for (auto const at : used)
            if (load_[at] > m.load) m = {load_[at], resource(at)};
        if (with_issue)
            for (auto const& [core, load] : issues_)
                if (load > m.load) m = {load, {NetworkResource::issue, {core, 0}, ' '}};
        return m;
    }
    void clear()
    {
        for (auto const at : used_) load_[at] = 0;
        used_.clear();
        issues_.clear();
    }
    /// The links of a transfer's way.
    std::uint64_t hops(NetworkTransfer const& t) const
    {
        std::uint64_t hops = 0;
        along(t, [&](std::size_t, NetworkNode, NetworkNode) { ++hops; });
        return hops;
    }

private:
    static constexpr std::size_t per_node = 2 + 2 + 1 + 2 * 4;
    struct Met {
        std::uint32_t sources[3]; ///< numbers from 1; 0: none
    };
    std::size_t chip_of(NetworkNode const& at) const noexcept { return std::size_t{at.y / n_.chip_rows} * chips_across_ + at.x / n_.chip_columns; }
    std::size_t node(NetworkNode const& at) const noexcept { return std::size_t{at.y} * n_.columns + at.x; }
    NetworkNode node_at(std::size_t i) const noexcept
    {
        return {static_cast<std::uint32_t>(i % n_.columns), static_cast<std::uint32_t>(i / n_.columns)};
    }
    NetworkResource resource(std::size_t at) const
    {
        using R = NetworkResource;
        if (at < 2 * nodes_) return {R::port_out, node_at(at % nodes_), ' '};
        if (at < 4 * nodes_) return {R::port_in, node_at(at % nodes_), ' '};
        if (at < 5 * nodes_) return {R::memory, node_at(at % nodes_), ' '};
        if (at >= 13 * nodes_) {
            auto const border = static_cast<std::uint32_t>(at - 13 * nodes_);
            return {R::border, {border / 4 % chips_across_, border / 4 / chips_across_}, "ewsn"[border % 4]};
        }
        std::size_t const link = at - 5 * nodes_;
        return {R::link, node_at(link / 4 % nodes_), "ewsn"[link % 4]};
    }
    /// Calls f(link, from, to) for each link of a transfer's way.
    template <class F>
    void along(NetworkTransfer const& t, F const& f) const
    {
        std::size_t const way = t.way == NetworkWay::columns_first ? 0 : 1;
        NetworkNode at = t.source;
        auto const step = [&](bool in_x) {
            std::uint32_t& place = in_x ? at.x : at.y;
            std::uint32_t const to = in_x ? t.sink.x : t.sink.y, size = in_x ? n_.columns : n_.rows;
            while (place != to) {
                bool const up = n_.torus ? way == 0 : to > place; // to larger numbers: east, south
                auto const from = at;
                auto const link = (way * nodes_ + node(at)) * 4 + (in_x ? (up ? 0u : 1u) : (up ? 2u : 3u));
                place = up ? (place + 1 == size ? 0 : place + 1) : (place == 0 ? size - 1 : place - 1);
                f(link, from, at);
            }
        };
        step(way == 0);
        step(way != 0);
    }

    Network const& n_;
    std::size_t nodes_;
    std::uint64_t scale_ = 1;
    std::uint32_t chips_across_ = 1;
    std::vector<std::uint32_t> memory_;
    std::vector<std::uint64_t> load_; ///< ports out, in, memory, links, borders
    std::vector<std::size_t> used_;
    std::vector<Met> met_;
    std::map<std::uint32_t, std::uint64_t> issues_;
};

TILEMESH_HOST void check_network(Network const& n, std::span<NetworkTransfer const> phase)
{
    constexpr std::uint64_t most = 1'000'000;
    if (n.columns == 0 || n.rows == 0 || n.columns > 1024 || n.rows > 1024)
        throw Error("a network of " + std::to_string(n.columns) + " x " + std::to_string(n.rows) +
                    " nodes (each side is 1 to 1,024); correct the network");
    for (auto const* number : {&n.link, &n.port_in, &n.port_out, &n.memory, &n.border, &n.flit, &n.packet, &n.head, &n.hop, &n.issue, &n.outstanding})
        if (number->value > most)
            throw Error("a number of network " + n.name + " that is " + std::to_string(number->value) + " (at most 1,000,000); correct the network");
    for (auto const* number : {&n.latency, &n.crossing})
        if (number->value > 1'000'000 * most)
            throw Error("a number of network " + n.name + " that is " + std::to_string(number->value) + " (at most 10^12); correct the network");
    if ((n.chip_columns == 0) != (n.chip_rows == 0))
        throw Error("chips of " + std::to_string(n.chip_columns) + " x " + std::to_string(n.chip_rows) + " nodes in network " + n.name +
                    " (0 x 0 means that it is one chip); give both sides");
    for (auto const* rate : {&n.link, &n.port_in, &n.port_out, &n.memory, &n.border})
        if (rate->value > 4096 || rate->per > 100 * most)
            throw Error("a rate of network " + n.name + " of " + std::to_string(rate->value) + " bytes a cycle (at most 4,096); correct the network");
    if (n.flit.value == 0 || n.packet.value == 0)
        throw Error("network " + n.name + " with flits or packets of 0 bytes (bytes go in flits); give their sizes");
    if (phase.empty()) throw Error("a phase without transfers (nothing takes time); leave it out");
    for (auto const& t : phase) {
        for (auto const& node : {t.source, t.sink})
            if (node.x >= n.columns || node.y >= n.rows)
                throw Error("a transfer at node (" + std::to_string(node.x) + ", " + std::to_string(node.y) + ") (network " + n.name + " has " +
                            std::to_string(n.columns) + " x " + std::to_string(n.rows) + "); correct the transfer");
        if (t.bytes > std::uint64_t{1} << 30) throw Error("a transfer of " + std::to_string(t.bytes) + " bytes (at most 2^30); divide it");
    }
}
} // namespace model_detail

TILEMESH_HOST NetworkTime time_of(Network const& network, std::span<NetworkTransfer const> phase)
{
    model_detail::check_network(network, phase);
    model_detail::NetworkLoads loads(network);
    auto const real = [](std::uint64_t n) { return static_cast<double>(n); };
    double cycles_at_most = real(network.crossing.value); // of everything on one resource, at a byte a cycle, generously
    double const slowest = real(std::max({network.link.per, network.port_in.per, network.port_out.per, network.memory.per, network.border.per}));
    for (auto const& t : phase) {
        double const packets = real(t.bytes / network.packet.value + 1);
        cycles_at_most += (real(t.bytes) + real(network.flit.value) + packets * real(network.head.value)) * (slowest + 1) +
                          packets * real(network.hop.value) + real(network.issue.value);
    }
    if (cycles_at_most * real(loads.scale()) > 9e18)
        throw Error("a phase of " + std::to_string(phase.size()) + " transfers whose loads do not fit 64 bits (the rates have the common multiple " +
                    std::to_string(loads.scale()) + "); divide the phase");
    std::uint64_t way = 0;
    for (auto const& t : phase) {
        loads.add(t, false);
        auto back = t;
        std::swap(back.source, back.sink);
        way = std::max(way, loads.hops(t) + loads.hops(back)); // the request, and its answer
    }
    auto const cycles = [&](std::uint64_t load) { return (load + loads.scale() - 1) / loads.scale(); };
    auto const all = loads.most(true);
    std::uint64_t const start = way * network.hop.value + network.latency.value;
    NetworkTime time{cycles(loads.most(false).load), cycles(all.load) + start, 0, all.resource};
    loads.clear();

    // Rounds: the 0th to 5th transfer of each core, its 6th to 11th, and so on.
    std::map<std::uint32_t, std::uint64_t> started;
    std::vector<std::vector<std::size_t>> rounds;
    for (std::size_t i = 0; i < phase.size(); ++i) {
        loads.meet(phase[i]);
        auto const number = started[phase[i].core]++;
        std::size_t const round = network.outstanding.value == 0 ? 0 : static_cast<std::size_t>(number / network.outstanding.value);
        if (round >= rounds.size()) rounds.resize(round + 1);
        rounds[round].push_back(i);
    }
    std::uint64_t sum = 0;
    for (auto const& round : rounds) {
        for (auto const i : round) loads.add(phase[i], true);
        sum += loads.most(true).load;
        loads.clear();
    }
    time.drained = cycles(sum) + start;
    return time;
}

}} // namespace tilemesh
