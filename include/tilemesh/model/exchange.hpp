#pragma once
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/network.hpp>
#include <vector>

// Every exchange that a cost model has is one of a network: this header gives the network, and a superstep's transfers on it.
namespace tilemesh { inline namespace v0_2 {

/// The compiled exchange of a model as a network, with a node a tile: only the ports in bound it, at `exchange_byte`, and the borders of
/// `model.chips`; `exchange` is its latency. A model with this network, without chips, and with 0 for `exchange` costs the same for every
/// trace, to the cycle; so does an exchange from any tile to any tile (any_to_any), in which each tile is the sink of what settles there.
/// Throws Error for a grid with a side above 1,024, and for chips as time_of does.
TILEMESH_HOST Network exchange_network(CostModel const& model, Grid grid);

/// The node of a tile. Tiles lie in the network's columns without memory channels, from the west. Throws Error for a grid that has no room.
TILEMESH_HOST std::vector<NetworkNode> nodes_of(Network const& network, Grid grid);

/// The transfers of a superstep: what each tile sends to each neighbour, its core starting one after the other. On a torus, whose links go
/// one way round, what goes west or north takes the second network. With `capacity`, every tile receives all slots of all its sides, whatever
/// was sent, and at an edge from itself. `nodes` is the result of nodes_of. Empty: nothing is sent.
TILEMESH_HOST std::vector<NetworkTransfer> exchange_transfers(Network const& network, std::vector<NetworkNode> const& nodes,
                                                              SuperstepSample const& superstep, Grid grid, ExchangeCost cost);

/// The words for what bounds a superstep: the largest of compute, exchange, sync and vote, the first of equals. Compute names its slowest
/// tile, and an exchange its busiest resource: "compute (3 7)", "port in (3 7)", "link (3 7) e", "border (0 0) s", "issue 12"; "exchange" if
/// its fixed cycles take longer than any resource. Empty if the superstep costs nothing.
TILEMESH_HOST std::string bound_text(SuperstepCost const& cost, Grid grid);
/// The same without the place: "compute", "port in", "exchange".
TILEMESH_HOST char const* bound_kind(SuperstepCost const& cost) noexcept;

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/exchange_code.hpp>
#endif
