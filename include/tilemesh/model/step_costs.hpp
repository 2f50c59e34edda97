#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/model/cost_model.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// A unique name for each step of a program: the name of its kernel. If several steps have one kernel, a number follows: "bloom 1", "bloom
/// 2". If a kernel itself has such a name, "bloom 1", every name begins with the step's place in the program.
TILEMESH_HOST std::vector<std::string> step_names(Trace const& trace);

/// The counts of one step of a program (one Superstep, Repeat or UntilQuiet) in a run, and its modelled cycles. All are sums over its
/// passes.
struct StepCost {
    std::string name;                     ///< from step_names
    std::uint64_t passes = 0;             ///< runs of its kernel over the tiles that had to run
    std::uint64_t exchanges = 0;          ///< exchanges that carried a message or a note
    std::uint64_t tile_runs = 0, sent_bytes = 0;
    std::uint64_t compute = 0, exchange = 0, sync = 0, vote = 0; ///< cycles; 0 without a cost model
    std::uint64_t total() const noexcept { return compute + exchange + sync + vote; }
    friend bool operator==(StepCost const&, StepCost const&) = default;
};

/// One round of a Loop in a run, and its supersteps.
struct LoopRound {
    std::uint32_t loop;         ///< number in Trace::loops
    std::uint64_t number;       ///< among the rounds of that Loop in the run, from 1
    std::size_t first, last;    ///< its supersteps
    friend bool operator==(LoopRound const&, LoopRound const&) = default;
};

/// The rounds of each Loop of the run, in order: loop by loop, then by time. A trace has no marks between rounds. A round begins where the
/// steps of a Loop begin anew. If this does not give as many rounds as the run counted (a round without a superstep, a Loop of one
/// UntilQuiet), the Loop has no rounds here. Cost: linear in the trace, for each Loop.
TILEMESH_HOST std::vector<LoopRound> loop_rounds(Trace const& trace);

/// The counts of each step of the run, in program order, without cycles. A step that never ran has zeros. Throws `Error` if the trace runs
/// a step that it does not name. Cost: linear in the trace.
TILEMESH_HOST std::vector<StepCost> step_costs(Trace const& trace);

/// The counts and the modelled cycles of each step of the run, in program order. `cost` must be the result of model_cost for this trace;
/// the totals add up to its cycles. Throws `Error` if `cost` is of another trace: another number of supersteps, or a superstep of another
/// step. Cost: linear in the trace.
TILEMESH_HOST std::vector<StepCost> step_costs(Trace const& trace, RunCost const& cost);

}} // namespace tilemesh

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/step_costs_code.hpp>
#endif
