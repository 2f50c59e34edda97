#pragma once
#include <span>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/machine/tile.hpp>
#include <tilemesh/model/step_costs.hpp>
#include <tilemesh/report/table.hpp>

namespace tilemesh { inline namespace v0_2 {

/// The modelled milliseconds of `cycles` as text, with four decimals (0.1 microseconds).
TILEMESH_HOST std::string milliseconds_text(CostModel const& model, std::uint64_t cycles);

/// The ledger of a tile's SRAM (Layout::ledger()) as a table for terminals: bytes by region, then the sum of the bytes that count
/// against `sram_bytes`.
TILEMESH_HOST report::Table ledger_table(std::span<machine::Region const> ledger, std::uint32_t sram_bytes);

/// A run's modelled cost as a table for terminals: a row for each step of the program, then their sum. The columns are passes, exchanges
/// that carried something, cycles, and milliseconds at the model's clock. `cost` must be the result of model_cost for this trace; throws
/// `Error` if it is of another trace.
TILEMESH_HOST report::Table cost_table(CostModel const& model, Trace const& trace, RunCost const& cost);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/cost_table_code.hpp>
#endif
