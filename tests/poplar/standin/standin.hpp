// Part of the stand-in for the Poplar SDK (never installed): its settings for tests, and its queries.
#pragma once
#include "detail/reports.hpp"
#include "detail/settings.hpp"
#include "poplar/Engine.hpp"
#include "poplar/Program.hpp"
#include "standin_vertex.hpp"
#include <cstddef>
#include <vector>

namespace standin {

/// Changes the settings during its lifetime, and then restores the old ones: `standin::With const with{{.threads = true}};`
class With {
public:
    explicit With(Settings const& wanted) : before_(settings()) { settings() = wanted; }
    With(With const&) = delete;
    With& operator=(With const&) = delete;
    ~With() { settings() = before_; }

private:
    Settings before_;
};

/// The contents of a tile in bytes, by name of variable, with temporaries, vertex state and code.
inline TileBytes tile_bytes(poplar::Engine const& engine, unsigned tile)
{
    return engine.executable().tile_bytes(tile);
}

/// The moves of a Copy between tensors from tile to tile. The Copy is in the engine's programs, or is a copy of that object.
inline std::vector<Move> moves(poplar::Engine const& engine, poplar::program::Program const& copy)
{
    return engine.executable().moves_of(copy);
}

/// All exchanges of an engine: first its Copies, in the order in which its programs first reach them; then, for each compute set, the
/// exchanges that Poplar would add before it (gather) and after it (scatter).
inline std::vector<Exchange> exchanges(poplar::Engine const& engine)
{
    return engine.executable().exchanges();
}

/// The counters of the last run, up to its exception if it threw one.
inline Counts last_run(poplar::Engine const& engine)
{
    return engine.executable().counts();
}

/// The counters of all runs of an engine together.
inline Counts all_runs(poplar::Engine const& engine) { return engine.executable().all_counts(); }

} // namespace standin
