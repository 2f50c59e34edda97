#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// What one step of a program (one Superstep, Repeat or UntilQuiet) did in a run. Exact and the same on every engine, any
/// number of threads; only `milliseconds` is measured.
struct StepCounters {
    std::string kernel;
    std::uint64_t passes = 0;          ///< compute phases
    std::uint64_t supersteps = 0;      ///< exchanges that carried something: a message or a note
    std::uint64_t tile_runs = 0;       ///< kernel calls on tiles that had to run
    std::uint64_t messages = 0;
    std::uint64_t live_bytes = 0;      ///< of messages
    std::uint64_t capacity_bytes = 0;  ///< what the compile-time exchange moves in these supersteps, whatever is live
    double milliseconds = 0;           ///< host time
};

/// The most that a buffer or an outgoing channel of any tile held at the end of a compute phase, in items.
struct Peak {
    std::string region;
    std::uint32_t items = 0;
    std::uint32_t capacity = 0;
};

/// The number of rounds that one Loop of a program made in a run. The StepCounters of its steps are sums over all rounds.
struct LoopCounters {
    std::uint32_t first = 0, last = 0;    ///< the Loop's first and last step
    std::uint64_t rounds = 0;
    friend bool operator==(LoopCounters const&, LoopCounters const&) = default;
};

struct RunCounters {
    std::vector<StepCounters> steps;      ///< in program order
    std::vector<LoopCounters> loops;      ///< in program order; an outer loop comes before its inner loops
    std::vector<Peak> peaks;            ///< buffers, then channels
    std::vector<std::uint64_t> digests; ///< one per pass, over all live words; empty unless asked for

    std::uint64_t supersteps() const noexcept { return sum(&StepCounters::supersteps); }
    std::uint64_t messages() const noexcept { return sum(&StepCounters::messages); }
    std::uint64_t tile_runs() const noexcept { return sum(&StepCounters::tile_runs); }

private:
    std::uint64_t sum(std::uint64_t StepCounters::*what) const noexcept
    {
        std::uint64_t n = 0;
        for (auto const& s : steps) n += s.*what;
        return n;
    }
};

/// What an observer is told after each superstep's exchange; meanwhile no tile runs and all of the mesh may be read.
struct SuperstepEvent {
    std::string const& kernel;
    std::uint32_t step;           ///< which step of the program
    std::uint64_t pass;           ///< compute phases since the run began, from 0
    std::uint64_t messages;       ///< sent in this one
    std::uint64_t tile_runs;
    std::uint64_t digest;         ///< 0 unless asked for
};
using Observer = std::function<void(SuperstepEvent const&)>;

}} // namespace tilemesh
