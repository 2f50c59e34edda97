#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/engine/facts.hpp>
#include <tilemesh/engine/not_quiet.hpp>
#include <tilemesh/engine/stopwatch.hpp>
#include <tilemesh/engine/store.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <utility>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace engine {

/// The counters of a program that has not run: all zero.
RunCounters begin_counters(ProgramFacts const& program);

/// The result of one superstep of an engine. All members are zero if no tile had to run.
struct Passed {
    bool ran = false, sent = false;
    std::uint64_t messages = 0, tile_runs = 0, live_bytes = 0;
};

/// The peaks of a store's lists, then of its channels. `items`: the most items that a list held, by states; `link_items`: by channels.
std::vector<Peak> list_peaks(StoreView const& store, std::uint32_t const* items, std::uint32_t const* link_items);

/// What a run knows without its program: the counters, the present step, the trace.
class RunState {
public:
    RunState();
    RunState(RunState&&) noexcept;
    RunState& operator=(RunState&&) noexcept;
    ~RunState();

    Observer observer;
    std::unique_ptr<Trace> trace; ///< of the last run; null: the run keeps none, as on a machine that is not Traced

    std::uint32_t step() const noexcept { return step_; }
    /// The supersteps of this run before the present one.
    std::uint64_t pass() const noexcept { return pass_; }
    std::string const& kernel() const noexcept { return counters_.steps[step_].kernel; }
    /// Keeps a trace of each run from now on; only on a Traced machine.
    void keep_trace();
    /// The trace of the last run. Throws Error if the run keeps none.
    Trace const& kept_trace() const;
    /// The Error for the first of `count` mistakes of kernels. It names the tile and the superstep.
    Error failed(Grid grid, std::uint32_t tile, std::string const& what, std::uint64_t count = 1) const;
    /// Takes the memory for the digest of the next superstep, so that it cannot be missing later.
    void make_room_for_digest();

    struct Limits {
        std::uint32_t most_passes; ///< for one UntilQuiet, and for the rounds of one Loop; 0: no limit
        bool digest;
        ExplainNotQuiet explain;
    };

protected:
    /// Takes the memory that a run needs before its first superstep. `operations`: by steps, if the run may keep a trace. Throws Error after
    /// a run that stopped on an error.
    void begin(ProgramFacts const& program, OperationNames const* operations);
    /// Counts a superstep and calls the observer. `capacity_bytes`: of its exchange.
    void count(Passed const& passed, std::uint64_t capacity_bytes, bool digest, std::uint64_t words);
    /// The next round of a Loop begins. Throws Error if it is one too many.
    void count_round(std::uint32_t loop, std::uint32_t round, Limits const& limits, Grid grid);
    /// A step did `passes` passes. Throws Error if they are too many.
    void check_passes(std::uint32_t passes, Limits const& limits, Grid grid) const;
    GoesOn goes_on(Limits const& limits, Grid grid) const;

    RunCounters counters_;
    std::uint32_t step_ = 0;
    std::uint64_t pass_ = 0;
    bool broken_ = false;
};

/// A run of a program: it interprets the program. Mesh and CheckedMesh share this class. Each has its own memory and exchange, so that
/// each checks the other. An engine supplies:
///   Passed superstep<Kernel, everywhere>()    runs one kernel on the tiles that must run, then its exchange
///   bool any_busy()                           did a tile vote busy in the superstep before?
///   std::uint64_t digest_now()
///   P const* shared<P>()
///   StoreView view()
template <class Program, bool Traced>
class Run : public RunState {
public:
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
        if constexpr (Traced)
            RunState::begin(program_facts<Program>, operations_of_steps<Program>.at);
        else
            RunState::begin(program_facts<Program>, nullptr);
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
            using Kernel = KernelOf<Step>;
            constexpr bool everywhere = StepTraits<Step>::everywhere;
            run.step_ = i;
            Stopwatch const stopwatch;
            auto const most = StepTraits<Step>::most(step);
            for (std::uint32_t n = 0; n < most;) {
                auto const passed = engine.template superstep<Kernel, everywhere>();
                if (!passed.ran) break;
                run.count(passed, passed.sent ? engine.view().capacity_bytes(kernel_facts<Program, Kernel>) : 0, limits.digest,
                          limits.digest ? engine.digest_now() : 0);
                ++n;
                if constexpr (!everywhere) run.check_passes(n, limits, grid);
            }
            run.counters_.steps[i].milliseconds += stopwatch.milliseconds();
        }
        template <class Part, class Body>
        void loop(Part const& part, LoopAt at, Body const& body)
        {
            for (std::uint32_t n = 0; n < part.at_most && engine.any_busy(); ++n) {
                run.count_round(at.index, n, limits, grid);
                body();
            }
        }
        template <class Part, class Body>
        void condition(Part const&, Body const& body)
        {
            using Traits = StepTraits<Part>;
            if (engine.template shared<typename Traits::Parameters>()->*Traits::flag != 0) body();
        }
    };
};

}}} // namespace tilemesh::engine

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/engine/detail/run_code.hpp>
#endif
