// Part of the stand-in for the Poplar SDK (never installed): how tests set it up and what they can ask it.
#pragma once
#include "detail/reports.hpp"
#include "detail/settings.hpp"
#include "poplar/Engine.hpp"
#include "poplar/Program.hpp"
#include "standin_vertex.hpp"
#include <cstddef>
#include <vector>

namespace standin {

/// Sets the settings for as long as it lives, then those from before: `standin::With const with{{.threads = true}};`
class With {
public:
    explicit With(Settings const& wanted) : before_(settings()) { settings() = wanted; }
    With(With const&) = delete;
    With& operator=(With const&) = delete;
    ~With() { settings() = before_; }

private:
    Settings before_;
};

/// What a tile holds, by name of variable, with temporaries, vertex state and code.
inline TileBytes tile_bytes(poplar::Engine const& engine, unsigned tile)
{
    return engine.executable().tile_bytes(tile);
}

/// What a Copy between tensors moves from tile to tile; the Copy is in the engine's programs, or a copy of that object.
inline std::vector<Move> moves(poplar::Engine const& engine, poplar::program::Program const& copy)
{
    return engine.executable().moves_of(copy);
}

/// All exchanges of an engine: its Copies, in the order in which its programs first reach them, then for each compute set what
/// Poplar would add before (gather) and after it (scatter).
inline std::vector<Exchange> exchanges(poplar::Engine const& engine)
{
    return engine.executable().exchanges();
}

/// What the last run did; what it did until then, if it ended with an exception.
inline Counts last_run(poplar::Engine const& engine)
{
    return engine.executable().counts();
}

/// What all its runs did together.
inline Counts all_runs(poplar::Engine const& engine) { return engine.executable().all_counts(); }

} // namespace standin
