#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/engine/not_quiet.hpp>
#include <tilemesh/engine/stopwatch.hpp>
#include <tilemesh/engine/store.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace engine {

/// Counters of a program's steps, all zero.
template <class... Step>
std::vector<StepCounters> begin_steps(machine::Types<Step...>)
{
    std::vector<StepCounters> steps;
    (steps.push_back({text(name_of<KernelOf<Step>>())}), ...);
    return steps;
}

/// Counters of a program's Loops, all zero.
template <class Program>
std::vector<LoopCounters> begin_loops()
{
    std::vector<LoopCounters> loops;
    auto const all = loops_of<Program>();
    for (std::uint32_t l = 0; l < StepTraits<Program>::loops; ++l) loops.push_back({all.found[l].first, all.found[l].last, 0});
    return loops;
}

/// The result of one superstep of an engine. All members are zero if no tile had to run.
struct Passed {
    bool ran = false, sent = false;
    std::uint64_t messages = 0, tile_runs = 0, live_bytes = 0;
};

/// The peaks of a program's lists, then of its channels. `of(tag)` returns the most items that a list held, and the list's capacity.
template <class... X, class... C, class F>
std::vector<engine::Peak> list_peaks(machine::Types<X...>, machine::Types<C...>, F const& of)
{
    std::vector<engine::Peak> peaks;
    [[maybe_unused]] auto const add = [&](auto tag) {
        using R = typename decltype(tag)::type;
        if constexpr (is_list<R> || is_channel<R>) {
            peaks.push_back(of(tag));
            peaks.back().region = text(name_of<R>());
        }
    };
    (add(machine::Tag<X>{}), ...);
    (add(machine::Tag<C>{}), ...);
    return peaks;
}

/// A run of a program: it interprets the program, counts, and knows the current step. Mesh and CheckedMesh share this class. Each has its
/// own memory and exchange, so that each checks the other. An engine supplies:
///   Passed superstep<Kernel, everywhere>()    runs one kernel on the tiles that must run, then its exchange
///   bool any_busy()                           did a tile vote busy in the superstep before?
///   std::uint64_t digest_now()
///   P const* shared<P>()
///   std::uint64_t capacity_bytes<Kernel>()    of one exchange
template <class Program, bool Traced>
class Run {
public:
    Observer observer;
    /// On a Traced machine: the trace of the last run, or null if the run keeps none.
    [[no_unique_address]] std::conditional_t<Traced, std::unique_ptr<Trace>, NoTrace> trace;

    std::uint32_t step() const noexcept { return step_; }
    /// The supersteps of this run before the present one.
    std::uint64_t pass() const noexcept { return pass_; }
    std::string const& kernel() const noexcept { return counters_.steps[step_].kernel; }
    /// Keeps a trace of each run from now on; only on a Traced machine.
    void keep_trace() { trace = std::make_unique<Trace>(); }
    /// The trace of the last run. Throws Error if the run keeps none.
    Trace const& kept_trace() const
    {
        if (!trace) throw Error("a trace of a mesh that keeps none (its options have trace = false); set it");
        return *trace;
    }
    /// The Error for the first of `count` mistakes of kernels. It names the tile and the superstep.
    Error failed(Grid grid, std::uint32_t tile, std::string const& what, std::uint64_t count = 1) const
    {
        return Error(what + " [tile " + text(grid.tile(tile)) + ", superstep " + std::to_string(pass_) + " (" + kernel() + ")" +
                     (count > 1 ? ", the first of " + std::to_string(count) + " broken contracts]" : "]"));
    }

    struct Limits {
        std::uint32_t most_passes; ///< for one UntilQuiet, and for the rounds of one Loop; 0: no limit
        bool digest;
        ExplainNotQuiet explain;
    };
    /// Runs the program once. `peaks()` returns the peaks of the run. Exceptions of supersteps and observers, and `std::bad_alloc`, pass
    /// through. Throws `Error` for a step or Loop that exceeds its limit. After an exception it refuses to run again.
    template <class Engine, class Peaks>
    RunCounters all(Engine& engine, Program const& program, Grid grid, Limits const& limits, Peaks const& peaks)
    {
        begin();
        return go_on(engine, program, grid, limits, peaks);
    }
    /// `all` in two parts, for an engine that must know on all processes that a part did not throw: `begin` takes the memory that a run needs
    /// before its first superstep, and `go_on` runs the program.
    void begin()
    {
        if (broken_) throw Error("a mesh that stopped on an error cannot run again (its state is half a superstep); build a new one");
        counters_ = {};
        counters_.steps = begin_steps(StepsOf<Program>{});
        counters_.loops = begin_loops<Program>();
        if constexpr (Traced)
            if (trace) *trace = begin_trace<Program>(counters_);
        step_ = 0;
        pass_ = 0;
    }
    template <class Engine, class Peaks>
    RunCounters go_on(Engine& engine, Program const& program, Grid grid, Limits const& limits, Peaks const& peaks)
    {
        broken_ = true;
        Interpreter<Engine> interpreter{*this, engine, grid, limits};
        walk(program, interpreter);
        counters_.peaks = peaks();
        broken_ = false;
        return std::move(counters_);
    }
    /// Takes the memory for the digest of the next superstep, so that it cannot be missing later.
    void make_room_for_digest()
    {
        auto& digests = counters_.digests;
        if (digests.size() == digests.capacity()) digests.reserve(2 * digests.size() + 64);
    }

private:
    template <class Engine>
    struct Interpreter {
        Run& run;
        Engine& engine;
        Grid grid;
        Limits limits;

        template <class Step>
        void step(Step const& step, std::uint32_t i)
        {
            constexpr bool everywhere = StepTraits<Step>::everywhere;
            run.step_ = i;
            Stopwatch const stopwatch;
            auto const most = StepTraits<Step>::most(step);
            for (std::uint32_t n = 0; n < most && superstep<KernelOf<Step>, everywhere>();)
                if (++n > limits.most_passes && !everywhere && limits.most_passes != 0)
                    throw goes_on().not_quiet(i);
            run.counters_.steps[i].milliseconds += stopwatch.milliseconds();
        }
        template <class Part, class Body>
        void loop(Part const& part, LoopAt at, Body const& body)
        {
            for (std::uint32_t n = 0; n < part.at_most && engine.any_busy(); ++n) {
                if (n == limits.most_passes && limits.most_passes != 0)
                    throw goes_on().not_done(run.counters_.loops[at.index]);
                ++run.counters_.loops[at.index].rounds;
                if constexpr (Traced)
                    if (run.trace) run.trace->loops = run.counters_.loops;
                body();
            }
        }
        template <class Part, class Body>
        void condition(Part const&, Body const& body)
        {
            using Traits = StepTraits<Part>;
            if (engine.template shared<typename Traits::Parameters>()->*Traits::flag != 0) body();
        }

        GoesOn goes_on() const
        {
            Trace const* written = nullptr;
            if constexpr (Traced) written = run.trace.get();
            return {run.kernel(), run.pass_ - 1, limits.most_passes, written, grid, limits.explain};
        }
        template <class Kernel, bool Everywhere>
        bool superstep()
        {
            auto const passed = engine.template superstep<Kernel, Everywhere>();
            if (!passed.ran) return false;
            auto& counters = run.counters_.steps[run.step_];
            ++counters.passes;
            counters.messages += passed.messages;
            counters.tile_runs += passed.tile_runs;
            counters.live_bytes += passed.live_bytes;
            if (passed.sent) {
                ++counters.exchanges;
                counters.capacity_bytes += engine.template capacity_bytes<Kernel>(typename KernelTraits<Kernel>::Links{});
            }
            std::uint64_t words = 0;
            if (limits.digest) run.counters_.digests.push_back(words = engine.digest_now());
            if (run.observer) run.observer({counters.kernel, run.step_, run.pass_, passed.messages, passed.tile_runs, words});
            ++run.pass_;
            return true;
        }
    };

    RunCounters counters_;
    std::uint32_t step_ = 0;
    std::uint64_t pass_ = 0;
    bool broken_ = false;
};

}}} // namespace tilemesh::engine
