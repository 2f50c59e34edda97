#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/network.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// What a run's modelled total rests on: its cycles by how the prices behind them are known.
struct Confidence {
    std::array<std::uint64_t, price_kind_names.size()> cycles{}; ///< by PriceKind; their sum is the run's total
    PriceKind weakest = PriceKind::documented;                   ///< of the kinds that took cycles
    std::vector<std::string> names;                              ///< of the prices of this kind that took cycles, those with the most first
};

/// The weakest kind of a network's numbers, those of 0 left out.
TILEMESH_HOST PriceKind kind_of_network(Network const& network) noexcept;

/// Splits a run's modelled cycles by the kinds of their prices. Compute is that of each pass's slowest tile; what rounding adds to it belongs
/// to `run`. A number that has no entry in `model.parameters` is a guess, and so is what borders between chips add. What a network adds to
/// `exchange` is as its weakest number. `cost` must be the result
/// of model_cost for this trace; throws `Error` if it is of another trace. Cost: linear in the trace.
TILEMESH_HOST Confidence confidence_of(CostModel const& model, Trace const& trace, RunCost const& cost);

/// One sentence that names the weakest kind, its prices and their share of the cycles; empty if no cycle was modelled.
TILEMESH_HOST std::string confidence_text(CostModel const& model, Trace const& trace, RunCost const& cost);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/confidence_code.hpp>
#endif
