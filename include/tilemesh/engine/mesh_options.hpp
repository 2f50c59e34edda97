#pragma once
#include <cstdint>
#include <tilemesh/engine/not_quiet.hpp>

namespace tilemesh { inline namespace v0_2 {

/// Options of a Mesh.
struct MeshOptions {
    std::uint32_t threads = 1; ///< at most 1,024, because more threads would have only a few tiles each
    bool digest = false; ///< fills RunCounters::digests; costs a pass over all live words in each superstep
    /// The largest number of passes of one UntilQuiet, and of rounds of one Loop; 0: no limit. A program may never become quiet, so `run`
    /// throws Error in the pass after the last one that is allowed.
    std::uint32_t most_passes = 0;
    /// On a Traced machine, `run` appends the text of this function to that error; null: no text. `explain_no_progress`
    /// (model/no_progress.hpp) is such a function: it names the steps that repeat.
    ExplainNotQuiet explain = nullptr;
    bool trace = true; ///< on a Traced machine, keeps a trace of the last run; a mesh of another machine never does
};

}} // namespace tilemesh
