#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tilemesh/engine/run.hpp>
#include <tilemesh/engine/stopwatch.hpp>
#include <tilemesh/engine/text.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace engine {

TILEMESH_HOST RunCounters begin_counters(ProgramFacts const& program)
{
    RunCounters counters;
    for (auto const& step : program.steps) {
        counters.steps.emplace_back();
        counters.steps.back().kernel = text(step.kernel->name);
    }
    for (auto const& loop : program.loops) counters.loops.push_back({loop.first, loop.last, 0});
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
    for (auto const& step : program.steps) {
        trace.kernels.push_back(text(step.kernel->name));
        trace.operations.emplace_back(operations->begin, operations->begin + operations->size);
        ++operations;
    }
    for (auto const& loop : program.loops) trace.loops.push_back({loop.first, loop.last, 0});
    return trace;
}

TILEMESH_HOST RunState::RunState() = default;
TILEMESH_HOST RunState::RunState(RunState&&) noexcept = default;
TILEMESH_HOST RunState& RunState::operator=(RunState&&) noexcept = default;
TILEMESH_HOST RunState::~RunState() = default;
TILEMESH_HOST void RunState::require_idle() const
{
    if (running_) throw Error("a mesh that its own observer changes or runs again (its run is not over); do it after the run");
}
TILEMESH_HOST void RunState::observe(Observer next)
{
    require_idle();
    observer = std::move(next);
}
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
    require_idle();
    if (broken_) throw Error("a mesh that stopped on an error cannot run again (its state is half a superstep); build a new one");
    program_ = &program;
    parts_.clear();
    counters_ = begin_counters(program);
    if (trace) *trace = begin_trace(program, operations);
    step_ = 0;
    pass_ = 0;
}

struct RunState::Interpreter {
    RunState& run;
    RunCalls const& calls;
    StoreView const& store;
    Limits const& limits;

    /// Interprets the parts [first, last).
    void parts(std::uint32_t first, std::uint32_t last) const
    {
        for (auto i = first; i < last;) {
            auto const& part = run.parts_[i];
            if (part.kind == Part::Kind::step) {
                step(part);
                ++i;
                continue;
            }
            if (part.kind == Part::Kind::loop)
                loop(part, i + 1);
            else if (*part.flag != 0)
                parts(i + 1, part.end);
            i = part.end;
        }
    }
    void step(Part const& part) const
    {
        run.step_ = part.number;
        Stopwatch const stopwatch;
        bool const everywhere = run.program_->steps[part.number].everywhere;
        for (std::uint32_t n = 0; n < part.most && superstep();)
            if (++n > limits.most_passes && !everywhere && limits.most_passes != 0) throw goes_on().not_quiet(part.number);
        run.counters_.steps[part.number].milliseconds += stopwatch.milliseconds();
    }
    void loop(Part const& part, std::uint32_t first) const
    {
        auto& counters = run.counters_.loops[part.number];
        for (std::uint32_t n = 0; n < part.most && calls.any_busy(calls.engine); ++n) {
            if (n == limits.most_passes && limits.most_passes != 0) throw goes_on().not_done(counters);
            ++counters.rounds;
            if (run.trace) run.trace->loops = run.counters_.loops;
            parts(first, part.end);
        }
    }
    bool superstep() const
    {
        auto const passed = calls.superstep(calls.engine);
        if (!passed.ran) return false;
        auto& counters = run.counters_.steps[run.step_];
        ++counters.passes;
        counters.messages += passed.messages;
        counters.tile_runs += passed.tile_runs;
        counters.live_bytes += passed.live_bytes;
        if (passed.sent) {
            ++counters.exchanges;
            counters.capacity_bytes += store.capacity_bytes(*run.program_->steps[run.step_].kernel);
        }
        std::uint64_t words = 0;
        if (limits.digest) run.counters_.digests.push_back(words = calls.digest(calls.engine));
        if (run.observer) run.observer({counters.kernel, run.step_, run.pass_, passed.messages, passed.tile_runs, words});
        ++run.pass_;
        return true;
    }
    GoesOn goes_on() const { return {run.kernel(), run.pass_ - 1, limits.most_passes, run.trace.get(), store.grid, limits.explain}; }
};

TILEMESH_HOST RunCounters RunState::go_on(RunCalls const& calls, StoreView const& store, Limits const& limits)
{
    Raised const running(running_);
    broken_ = true;
    Interpreter{*this, calls, store, limits}.parts(0, static_cast<std::uint32_t>(parts_.size()));
    counters_.peaks = calls.peaks(calls.engine);
    broken_ = false;
    return std::move(counters_);
}

}}} // namespace tilemesh::engine
