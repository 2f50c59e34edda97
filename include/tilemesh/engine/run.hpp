#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/engine/counters.hpp>
#include <tilemesh/engine/facts.hpp>
#include <tilemesh/engine/not_quiet.hpp>
#include <tilemesh/engine/store_view.hpp>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tuple>
#include <vector>

namespace tilemesh { inline namespace v0_2 { namespace engine {

/// The counters of a program that has not run: all zero.
RunCounters begin_counters(ProgramFacts const& program);
/// The empty trace of a run that has not begun. `operations`: by steps (operations_of_steps).
Trace begin_trace(ProgramFacts const& program, OperationNames const* operations);

/// The result of one superstep of an engine. All members are zero if no tile had to run.
struct Passed {
    bool ran = false, sent = false;
    std::uint64_t messages = 0, tile_runs = 0, live_bytes = 0;
};

/// The peaks of a store's lists, then of its channels. `items`: the most items that a list held, by states; `link_items`: by channels.
std::vector<Peak> list_peaks(StoreView const& store, std::uint32_t const* items, std::uint32_t const* link_items);

/// A part of a program value, in the order in which the parts run. A Loop or a condition stands before its parts.
struct Part {
    enum class Kind : std::uint8_t { step, loop, condition };
    Kind kind;
    std::uint32_t number = 0;            ///< of the step or the Loop
    std::uint32_t most = 0;              ///< passes of the step, rounds of the Loop
    std::uint32_t end = 0;               ///< of a Loop or a condition: the number of the part behind its parts
    std::uint32_t const* flag = nullptr; ///< of a condition: a word of a broadcast
};
/// Lists the parts of a program. `Shareds`: the tuple of its broadcasts.
template <class Shareds>
struct ListParts {
    std::vector<Part>& parts;
    Shareds const& shareds;

    template <class Step>
    void step(Step const& step, std::uint32_t i)
    {
        parts.push_back({Part::Kind::step, i, StepTraits<Step>::most(step)});
    }
    template <class P, class Body>
    void loop(P const& part, LoopAt at, Body const& body)
    {
        body_of({Part::Kind::loop, at.index, part.at_most}, body);
    }
    template <class P, class Body>
    void condition(P const&, Body const& body)
    {
        using Traits = StepTraits<P>;
        body_of({Part::Kind::condition, 0, 0, 0, &(std::get<typename Traits::Parameters>(shareds).*Traits::flag)}, body);
    }

private:
    template <class Body>
    void body_of(Part const& part, Body const& body)
    {
        auto const at = parts.size();
        parts.push_back(part);
        body();
        parts[at].end = static_cast<std::uint32_t>(parts.size());
    }
};

/// What an engine does for a run. Each function gets `engine`.
struct RunCalls {
    void* engine;
    Passed (*superstep)(void* engine);        ///< runs the kernel of the run's present step on the tiles that must run, then its exchange
    bool (*any_busy)(void* engine);           ///< did a tile vote busy in the superstep before?
    std::uint64_t (*digest)(void* engine);
    std::vector<Peak> (*peaks)(void* engine); ///< those of the run
};

/// A run of a program: it interprets the program, counts, and knows the present step. Mesh and CheckedMesh share this class. Each has its
/// own memory and exchange, so that each checks the other.
class RunState {
public:
    RunState();
    RunState(RunState&&) noexcept;
    RunState& operator=(RunState&&) noexcept;
    ~RunState();

    Observer observer; ///< set it by `observe`, unless no run can be under way
    std::unique_ptr<Trace> trace; ///< of the last run; null: the run keeps none, as on a machine that is not Traced

    std::uint32_t step() const noexcept { return step_; }
    /// The supersteps of this run before the present one.
    std::uint64_t pass() const noexcept { return pass_; }
    std::string const& kernel() const noexcept { return counters_.steps[step_].kernel; }
    /// Throws Error during a run, whose observer would end under its own call.
    void observe(Observer next);
    /// Throws Error if an observer calls it.
    void require_idle() const;
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
    /// Begins a run: lists the program's parts, and takes the memory that the run needs before its first superstep. `Traced`: may it keep a
    /// trace? `shareds`: the tuple of the program's broadcasts, whose flags the run reads later. Throws Error after a run that stopped on an
    /// error.
    template <bool Traced, class Program, class Shareds>
    void begin(Program const& program, Shareds const& shareds)
    {
        OperationNames const* operations = nullptr;
        if constexpr (Traced) operations = operations_of_steps<Program>.at;
        begin(program_facts<Program>, operations);
        ListParts<Shareds> list{parts_, shareds};
        walk(program, list);
    }
    /// Runs the program once. Exceptions of supersteps and observers, and `std::bad_alloc`, pass through. Throws `Error` if an UntilQuiet or
    /// a Loop exceeds `most_passes`. After any exception, the next `begin` throws `Error`.
    RunCounters go_on(RunCalls const& calls, StoreView const& store, Limits const& limits);

private:
    struct Interpreter;

    void begin(ProgramFacts const& program, OperationNames const* operations);

    ProgramFacts const* program_ = nullptr;
    std::vector<Part> parts_;
    RunCounters counters_;
    std::uint32_t step_ = 0;
    std::uint64_t pass_ = 0;
    bool broken_ = false, running_ = false;
};

}}} // namespace tilemesh::engine

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/engine/detail/run_code.hpp>
#endif
