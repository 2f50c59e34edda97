#pragma once
#include <cstdint>
#include <ostream>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <tilemesh/model/step_costs.hpp>
#include <vector>

/// Files from a trace: two tables, a timeline for trace viewers, and sums for heat maps. Every byte follows from the trace, the
/// model and the grid alone: no clock, no locale, no rounding of a count. A trace of another grid throws `tilemesh::Error`. The
/// caller must check whether the stream took the bytes.
namespace tilemesh { inline namespace v0_2 {

namespace model_detail {
/// A field of a CSV line (RFC 4180): in quotes if it needs them, with each quote in it doubled.
TILEMESH_HOST std::string csv_field(std::string_view text);
} // namespace model_detail

namespace model_detail {
/// Writes the lines of write_trace_csv. Without prices no line has cycles.
TILEMESH_HOST void write_tile_lines(std::ostream& out, Trace const& trace, StepPrices const* prices, Grid grid);
} // namespace model_detail

/// Writes a line of names, and one line for each superstep and each tile that ran in it, in the trace's order: superstep (from 0), step of
/// the program, kernel, tile, each operation that a kernel of the program counts, bytes sent to each side, bytes that settled, and the
/// tile's cycles of compute under `model`. The format is RFC 4180 with Unix line ends.
///
/// Cost: at most about 125 bytes per line; 27 MB for 150 supersteps in which all of 1,440 tiles run.
TILEMESH_HOST void write_trace_csv(std::ostream& out, Trace const& trace, CostModel const& model, Grid grid);
/// Writes these lines without a cost model, and so without cycles.
TILEMESH_HOST void write_trace_csv(std::ostream& out, Trace const& trace, Grid grid);

/// Writes a line of names, and one line per superstep: superstep (from 0), step of the program, kernel, tiles that ran, cycles of
/// each phase, and the slowest tile, which is empty if no tile computed for a cycle. A model of several chips adds the bytes over the busiest
/// border between chips, and the cycles by which the borders prolong the exchange.
TILEMESH_HOST void write_step_csv(std::ostream& out, Trace const& trace, CostModel const& model, Grid grid);

/// Writes the run as a timeline for Perfetto (ui.perfetto.dev) and chrome://tracing: Trace Event Format, JSON. The first track shows
/// the steps of the program by name (step_names). The second track is the machine: compute, exchange, sync and vote of each superstep,
/// in the order in which the model adds them up. Then comes a track for each Loop whose rounds can be told apart (loop_rounds), with the
/// numbers of the rounds. Then come tracks of the `busiest` tiles with the most compute cycles of the whole run,
/// most first; of equal tiles, the lower index comes first. Their events have the step's name and the counts of operations. Events
/// without a cycle are left out.
///
/// Times are the model's cycles at its clock, cut to whole nanoseconds, as Perfetto stores them. `args.cycles` is exact. Perfetto drops an
/// event that overlaps the previous event by a nanosecond. Readers turn microseconds into nanoseconds by truncating a product that may be
/// a little too low (1.009 * 1000). So each `ts` is a quarter of a nanosecond larger, and readers get the exact start of an event. If a
/// reader gets a `dur` that is too low, the gap is too small to see.
///
/// A clock of 0 kHz or above `most_clock_khz` throws `tilemesh::Error`. A run must be below 500 years (2^64 ns). Cost: about 280 bytes
/// per event if counts have six digits; with 64 tiles, 2.7 MB for 150 supersteps on any grid.
TILEMESH_HOST void write_chrome_trace(std::ostream& out, Trace const& trace, CostModel const& model, Grid grid, std::uint32_t busiest = 64);

/// The number that a heat map shows for each tile, besides operations.
enum class TileSum : std::uint32_t {
    busy_cycles, ///< cycles in which the tile computes
    idle_cycles, ///< cycles in which it waits in compute phases for the slowest tile, even if it did not run
    sent_bytes,  ///< bytes of messages and their heads, towards all sides, and at an edge to itself
    tile_runs,   ///< kernel calls
    settled_bytes, ///< bytes of messages that arrived and went no further
    /// Not a sum: the largest share of a side's channel ends, including heads, that its messages took in any superstep. With 1 every slot
    /// is full. If a kernel sends on several channels, the share is that of all of them together.
    channel_fill
};
inline constexpr std::uint32_t tile_sum_kinds = 6;
constexpr char const* name_of(TileSum sum) noexcept
{
    constexpr char const* names[tile_sum_kinds] = {"busy_cycles", "idle_cycles", "sent_bytes", "tile_runs", "settled_bytes", "channel_fill"};
    return names[static_cast<std::uint32_t>(sum)];
}

/// The sum of `what` over a run, for each tile in the order of the grid's indices. It is exact below 2^53. A share is rounded once.
TILEMESH_HOST std::vector<double> heat_map(Trace const& trace, CostModel const& model, Grid grid, TileSum what);

/// The count of `operation` in a run, for each tile in the order of the grid's indices. It is exact below 2^53. Throws `Error` for a
/// name that no kernel of the run has.
TILEMESH_HOST std::vector<double> heat_map(Trace const& trace, Grid grid, std::string_view operation);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/trace_files_code.hpp>
#endif
