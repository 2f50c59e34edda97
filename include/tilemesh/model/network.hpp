#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// A number of a network, and where it is from: "document: ...", "measured: ...", "fitted: ..." or "guess: ...".
struct NetworkNumber {
    std::uint64_t value;
    std::string source;
    std::uint64_t per = 1; ///< of a rate: `value` bytes in so many cycles
    friend bool operator==(NetworkNumber const&, NetworkNumber const&) = default;
};

/// A node of a network: a tile with its router, or a memory channel with one.
struct NetworkNode {
    std::uint32_t x, y;
    friend bool operator==(NetworkNode const&, NetworkNode const&) = default;
};

/// The route of a transfer. Both are dimension-ordered. Around a torus, links go one way: east and south, or north and west.
enum class NetworkWay : std::uint8_t { columns_first, rows_first };

/// How messages get from node to node: routers, their links, and what a core may have under way. A compiled exchange, an exchange from any
/// tile to any tile, and several chips are cases of it (exchange_network in model/exchange.hpp).
///
/// Time is counted, not simulated. Each link, port and memory channel takes a transfer's bytes at its rate; each core takes `issue` cycles to
/// start one. The busiest of them bounds the time from below. A core that waits for its answers cannot run ahead, so a phase drains in
/// rounds of `outstanding` transfers a core, and each round lasts as long as its busiest resource.
struct Network {
    std::string name;
    std::uint32_t columns = 1, rows = 1;
    bool torus = false;                         ///< links go one way round; otherwise they go both ways, and routes are the shortest
    std::vector<std::uint32_t> memory_columns{}; ///< nodes in these columns are memory channels
    NetworkNumber link{}, port_in{}, port_out{}, memory{}; ///< bytes a cycle; a rate of 0 bounds nothing
    NetworkNumber flit{}, packet{}, head{};     ///< bytes: of the smallest unit, of a packet's largest load, of its head
    NetworkNumber hop{};                        ///< cycles of a router
    NetworkNumber latency{};                    ///< cycles until the first byte, without hops
    NetworkNumber issue{};                      ///< cycles from one transfer of a core to its next
    NetworkNumber outstanding{};                ///< transfers of a core under way; 0: any number
    std::uint32_t chip_columns = 0, chip_rows = 0; ///< nodes of a chip, if the network lies on several, side by side; both 0: one chip
    NetworkNumber border{};                     ///< bytes a cycle over a border of two chips in one direction; its links share them
    NetworkNumber crossing{};                   ///< cycles of a border that bytes cross, besides
    /// Where the numbers of nodes are from. Only a file needs them (write_cost_model).
    struct Sources {
        std::string nodes{}, memory_columns{}, chip{};
        friend bool operator==(Sources const&, Sources const&) = default;
    } sources{};
    friend bool operator==(Network const&, Network const&) = default;
};

/// Tenstorrent's Wormhole: 10 x 12 nodes, two networks, DRAM in columns 0 and 5. Of its numbers, two are fitted: issue and outstanding.
TILEMESH_HOST Network wormhole();

/// Tenstorrent's Blackhole: 17 x 12 nodes, two networks. All numbers are from documents; those that no document has are 0 and bound nothing.
TILEMESH_HOST Network blackhole();

/// Bytes that go from `source` to `sink`. A read is started by its sink, a write by its source.
struct NetworkTransfer {
    NetworkNode source, sink;
    NetworkWay way;
    std::uint64_t bytes;
    std::uint32_t core; ///< the core that starts it; any numbers
};

/// A part of a network that takes time.
struct NetworkResource {
    enum Kind : std::uint32_t { none, port_out, port_in, memory, link, border, issue };
    static constexpr char const* names[] = {"none", "port out", "port in", "memory channel", "link", "border", "issue"};
    Kind kind = none;
    NetworkNode at{};        ///< border: the chip that sends; issue: (core, 0)
    char side = ' ';         ///< of a link or border: e, w, s, n
    friend bool operator==(NetworkResource const&, NetworkResource const&) = default;
};

/// The cycles of a phase: transfers that start together, until the last one has arrived.
struct NetworkTime {
    std::uint64_t at_least; ///< of the busiest link, port or memory channel alone. With documented rates, no machine is faster
    std::uint64_t loaded;   ///< of the busiest resource, cores included, with the longest way and the latency
    std::uint64_t drained;  ///< the prediction: the same in rounds; never below `at_least`
    NetworkResource bound;  ///< the busiest resource, cores included
};

/// The time of a phase. Transfers of a core stand in the order in which it starts them.
///
/// A packet takes whole flits and its head. In `drained`, a packet from a memory channel waits one hop again on each link that packets of
/// more than two nodes share, because their answers meet there. Sums are exact: in units of a cycle over the product of the rates, rounded
/// up at the end. Throws Error for a network without nodes, for numbers above 10^6 (latency, crossing: 10^12) and rates above 4,096, for chips
/// with one side of 0, for a node outside the network, for more than 2^30 bytes in a transfer, and for a phase without transfers. Cost: a
/// look at each link of each way, twice.
TILEMESH_HOST NetworkTime time_of(Network const& network, std::span<NetworkTransfer const> phase);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/network_code.hpp>
#endif
