#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <tilemesh/error.hpp>
#include <tilemesh/model/exchange.hpp>

namespace tilemesh { inline namespace v0_2 {

TILEMESH_HOST Network exchange_network(CostModel const& model, Grid grid)
{
    auto const source = [&](char const* name) {
        auto const p =
            std::find_if(model.parameters.begin(), model.parameters.end(), [&](ModelParameter const& known) { return known.name == name; });
        return p == model.parameters.end() ? std::string("guess: it has no source") : p->source;
    };
    // So many millicycles a byte are 1,000 bytes in so many cycles.
    auto const rate = [](std::uint64_t millicycles, std::string from) {
        auto const shared = std::gcd(std::uint64_t{1000}, millicycles);
        return NetworkNumber{1000 / shared, std::move(from), millicycles / shared};
    };
    if (grid.width > 1024 || grid.height > 1024)
        throw Error("an exchange on a grid of " + std::to_string(grid.width) + " x " + std::to_string(grid.height) +
                    " tiles as a network (each side is 1 to 1,024); take a smaller grid");
    Network n;
    n.name = model.name;
    n.columns = grid.width, n.rows = grid.height;
    n.sources = {"document: a node a tile", "", model.chips.source};
    n.port_in = rate(model.exchange_millicycles_a_byte, source("exchange_byte"));
    n.flit = {1, "document: a compiled exchange has no packets"};
    n.packet = {std::uint64_t{1} << 19, "document: a compiled exchange has no packets"};
    n.latency = {model.exchange_cycles, source("exchange")};
    if (model.chips.columns != 0 || model.chips.rows != 0) {
        n.chip_columns = model.chips.columns, n.chip_rows = model.chips.rows;
        n.border = rate(model.chips.crossing_millicycles_a_byte, model.chips.source);
        n.crossing = {model.chips.crossing_cycles, model.chips.source};
    }
    return n;
}

TILEMESH_HOST std::vector<NetworkNode> nodes_of(Network const& network, Grid grid)
{
    std::vector<std::uint32_t> columns;
    for (std::uint32_t x = 0; x < network.columns; ++x)
        if (std::find(network.memory_columns.begin(), network.memory_columns.end(), x) == network.memory_columns.end()) columns.push_back(x);
    if (grid.width > columns.size() || grid.height > network.rows)
        throw Error("a grid of " + std::to_string(grid.width) + " x " + std::to_string(grid.height) + " tiles on network " + network.name +
                    " (it has room for " + std::to_string(columns.size()) + " x " + std::to_string(network.rows) + "); take a smaller grid");
    std::vector<NetworkNode> nodes;
    for (std::uint32_t t = 0; t < grid.size(); ++t) nodes.push_back({columns[grid.tile(t).x()], grid.tile(t).y()});
    return nodes;
}

TILEMESH_HOST std::vector<NetworkTransfer> exchange_transfers(Network const& network, std::vector<NetworkNode> const& nodes,
                                                              SuperstepSample const& superstep, Grid grid, ExchangeCost cost)
{
    std::vector<NetworkTransfer> out;
    auto const send = [&](std::uint32_t from, std::uint32_t to, Direction d, std::uint64_t bytes) {
        bool const second = network.torus && (d == Direction::west || d == Direction::north);
        if (bytes != 0) out.push_back({nodes[from], nodes[to], second ? NetworkWay::rows_first : NetworkWay::columns_first, bytes, from});
    };
    if (cost == ExchangeCost::capacity) {
        for (std::uint32_t t = 0; t < grid.size(); ++t)
            for (Direction d : news) {
                auto const tile = grid.tile(t);
                auto const edge = (d == Direction::east && tile.x() + 1 == grid.width) || (d == Direction::west && tile.x() == 0) ||
                                  (d == Direction::south && tile.y() + 1 == grid.height) || (d == Direction::north && tile.y() == 0);
                send(t, edge ? t : grid.index_of(grid.neighbour(tile, d, superstep.edge)), d, superstep.capacity_towards(d));
            }
        return out;
    }
    for (auto const& t : superstep.tiles)
        for (Direction d : news) send(t.tile, grid.index_of(grid.neighbour(grid.tile(t.tile), d, superstep.edge)), d, t.sent_bytes[index(d)]);
    return out;
}

TILEMESH_HOST char const* bound_kind(SuperstepCost const& cost) noexcept
{
    auto const most = std::max({cost.compute, cost.exchange, cost.sync, cost.vote});
    if (most == 0) return "";
    if (cost.compute == most) return "compute";
    if (cost.exchange != most) return cost.sync == most ? "sync" : "vote";
    return cost.bound.kind == NetworkResource::none ? "exchange" : NetworkResource::names[cost.bound.kind];
}

TILEMESH_HOST std::string bound_text(SuperstepCost const& cost, Grid grid)
{
    auto const at = [](NetworkNode const& node) { return " (" + std::to_string(node.x) + " " + std::to_string(node.y) + ")"; };
    std::string const kind = bound_kind(cost);
    auto const most = std::max({cost.compute, cost.exchange, cost.sync, cost.vote});
    if (most == 0) return kind;
    if (cost.compute == most) return kind + at({grid.tile(cost.slowest).x(), grid.tile(cost.slowest).y()});
    auto const& r = cost.bound;
    if (cost.exchange != most || r.kind == NetworkResource::none) return kind;
    if (r.kind == NetworkResource::issue) return kind + " " + std::to_string(r.at.x);
    return kind + at(r.at) + (r.side == ' ' ? "" : std::string(" ") + r.side);
}

namespace model_detail {

TILEMESH_HOST NetworkPrices::NetworkPrices(CostModel const& model, Grid grid) : model_(model), grid_(grid)
{
    if (!model.network) return;
    if (model.chips != Chips{})
        throw Error("cost model \"" + model.name +
                    "\" has a network and chips (a network says itself on how many chips it lies); leave one of them out");
    network_ = *model.network;
    nodes_ = nodes_of(network_, grid);
    if (network_.torus || !network_.memory_columns.empty() || network_.chip_columns != 0) return;
    network_.columns = std::min(network_.columns, grid.width); // a wafer has a hundred times the nodes of such a part
    network_.rows = std::min(network_.rows, grid.height);
}

TILEMESH_HOST NetworkTime NetworkPrices::of(SuperstepSample const& superstep)
{
    bool const whole = model_.exchange_cost == ExchangeCost::capacity;
    std::array<std::uint32_t, 4> sides{};
    for (Direction d : news) sides[index(d)] = superstep.capacity_towards(d);
    if (whole)
        if (auto const known = of_capacity_.find(sides); known != of_capacity_.end()) return known->second;
    auto const transfers = exchange_transfers(network_, nodes_, superstep, grid_, model_.exchange_cost);
    auto const latency = network_.latency.value; // of an exchange that carries nothing
    auto const time = transfers.empty() ? NetworkTime{0, latency, latency, {}} : time_of(network_, transfers);
    if (whole) of_capacity_.emplace(sides, time);
    return time;
}

} // namespace model_detail
}} // namespace tilemesh
