#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace tilemesh { inline namespace v0_2 {

/// The counts of one step of a program (one Superstep, Repeat or UntilQuiet) in a run. They are exact, and equal on every engine and with
/// any number of threads. Only `milliseconds` is measured.
struct StepCounters {
    std::string kernel;
    std::uint64_t passes = 0;          ///< runs of the kernel over the tiles that must run
    std::uint64_t exchanges = 0;       ///< exchanges that moved at least one message or note
    std::uint64_t tile_runs = 0;       ///< kernel calls on tiles that had to run
    std::uint64_t messages = 0;
    std::uint64_t live_bytes = 0;      ///< bytes of messages: their number times their size, without the 8-byte heads of channel ends
    std::uint64_t capacity_bytes = 0;  ///< bytes that the compile-time exchange moves in these exchanges, live or not, with the 8-byte heads
    double milliseconds = 0;           ///< host time
};

namespace engine {
/// The most items that a buffer or an outgoing channel of any tile held at the end of a pass.
struct Peak {
    std::string region;
    std::uint32_t items = 0;
    std::uint32_t capacity = 0;
};
} // namespace engine

/// The number of rounds of one Loop of a program in a run. The StepCounters of its steps are sums over all rounds.
struct LoopCounters {
    std::uint32_t first = 0, last = 0;    ///< the Loop's first and last step
    std::uint64_t rounds = 0;
    friend bool operator==(LoopCounters const&, LoopCounters const&) = default;
};

struct RunCounters {
    std::vector<StepCounters> steps;      ///< in program order
    std::vector<LoopCounters> loops;      ///< in program order; an outer loop comes before its inner loops
    std::vector<engine::Peak> peaks;      ///< buffers, then channels
    std::vector<std::uint64_t> digests;   ///< one per pass, over all live words; empty unless requested

    std::uint64_t exchanges() const noexcept { return sum(&StepCounters::exchanges); }
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

namespace engine {
/// Sets a flag for as long as it lives. The flag says that a run is under way; an observer must not start another.
class Raised {
public:
    explicit Raised(bool& flag) noexcept : flag_(flag) { flag_ = true; }
    ~Raised() { flag_ = false; }
    Raised(Raised const&) = delete;
    Raised& operator=(Raised const&) = delete;

private:
    bool& flag_;
};
} // namespace engine

/// The facts that an observer gets after each superstep's exchange. During the call no tile runs, and all of the mesh may be read.
/// An observer must not destroy what it observes; a call that would run or change it throws Error.
struct SuperstepEvent {
    std::string const& kernel;
    std::uint32_t step;           ///< number of the step in the program
    std::uint64_t pass;           ///< passes since the run began, from 0
    std::uint64_t messages;       ///< messages sent in this superstep
    std::uint64_t tile_runs;
    std::uint64_t digest;         ///< 0 unless requested
};
using Observer = std::function<void(SuperstepEvent const&)>;

}} // namespace tilemesh
