#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tilemesh/engine/run.hpp>
#include <tilemesh/engine/text.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace engine {

TILEMESH_HOST RunCounters begin_counters(ProgramFacts const& program)
{
    RunCounters counters;
    for (auto const& step : steps_of(program)) {
        counters.steps.emplace_back();
        counters.steps.back().kernel = text(step.kernel);
    }
    for (auto const& loop : loops_of(program)) counters.loops.push_back({loop.first, loop.last, 0});
    return counters;
}
TILEMESH_HOST std::vector<Peak> list_peaks(StoreView const& store, std::uint32_t const* items, std::uint32_t const* link_items)
{
    std::vector<Peak> peaks;
    for (std::uint32_t s = 0; s < store.state_count; ++s)
        if (store.states[s].list) peaks.push_back({text(store.states[s].name), items[s], store.capacities[s]});
    for (std::uint32_t l = 0; l < store.link_count; ++l)
        peaks.push_back({text(store.links[l].name), link_items[l], store.link_capacities[l]});
    return peaks;
}
TILEMESH_HOST Trace begin_trace(ProgramFacts const& program, OperationNames const* operations)
{
    Trace trace;
    for (auto const& step : steps_of(program)) {
        trace.kernels.push_back(text(step.kernel));
        trace.operations.emplace_back(operations->begin, operations->begin + operations->size);
        ++operations;
    }
    for (auto const& loop : loops_of(program)) trace.loops.push_back({loop.first, loop.last, 0});
    return trace;
}

TILEMESH_HOST RunState::RunState() = default;
TILEMESH_HOST RunState::RunState(RunState&&) noexcept = default;
TILEMESH_HOST RunState& RunState::operator=(RunState&&) noexcept = default;
TILEMESH_HOST RunState::~RunState() = default;
TILEMESH_HOST void RunState::keep_trace() { trace = std::make_unique<Trace>(); }
TILEMESH_HOST Trace const& RunState::kept_trace() const
{
    if (!trace) throw Error("a trace of a mesh that keeps none (its options have trace = false); set it");
    return *trace;
}
TILEMESH_HOST Error RunState::failed(Grid grid, std::uint32_t tile, std::string const& what, std::uint64_t count) const
{
    return Error(what + " [tile " + text(grid.tile(tile)) + ", superstep " + std::to_string(pass_) + " (" + kernel() + ")" +
                 (count > 1 ? ", the first of " + std::to_string(count) + " broken contracts]" : "]"));
}
TILEMESH_HOST void RunState::make_room_for_digest()
{
    auto& digests = counters_.digests;
    if (digests.size() == digests.capacity()) digests.reserve(2 * digests.size() + 64);
}
TILEMESH_HOST void RunState::begin(ProgramFacts const& program, OperationNames const* operations)
{
    if (broken_) throw Error("a mesh that stopped on an error cannot run again (its state is half a superstep); build a new one");
    counters_ = begin_counters(program);
    if (trace) *trace = begin_trace(program, operations);
    step_ = 0;
    pass_ = 0;
}
TILEMESH_HOST void RunState::count(Passed const& passed, std::uint64_t capacity_bytes, bool digest, std::uint64_t words)
{
    auto& counters = counters_.steps[step_];
    ++counters.passes;
    counters.messages += passed.messages;
    counters.tile_runs += passed.tile_runs;
    counters.live_bytes += passed.live_bytes;
    if (passed.sent) {
        ++counters.exchanges;
        counters.capacity_bytes += capacity_bytes;
    }
    if (digest) counters_.digests.push_back(words);
    if (observer) observer({counters.kernel, step_, pass_, passed.messages, passed.tile_runs, words});
    ++pass_;
}
TILEMESH_HOST GoesOn RunState::goes_on(Limits const& limits, Grid grid) const
{
    return {kernel(), pass_ - 1, limits.most_passes, trace.get(), grid, limits.explain};
}
TILEMESH_HOST void RunState::check_passes(std::uint32_t passes, Limits const& limits, Grid grid) const
{
    if (passes > limits.most_passes && limits.most_passes != 0) throw goes_on(limits, grid).not_quiet(step_);
}
TILEMESH_HOST void RunState::count_round(std::uint32_t loop, std::uint32_t round, Limits const& limits, Grid grid)
{
    if (round == limits.most_passes && limits.most_passes != 0) throw goes_on(limits, grid).not_done(counters_.loops[loop]);
    ++counters_.loops[loop].rounds;
    if (trace) trace->loops = counters_.loops;
}

}}} // namespace tilemesh::engine
