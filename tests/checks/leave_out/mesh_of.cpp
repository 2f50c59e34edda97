// The engines that run the default's frame program: -DMACHINE=Mk2, or '-DMACHINE=Traced<Mk2>', which keeps a trace.
#include "setups.hpp"
#include <tilemesh/engine/checked_mesh.hpp>
#include <tilemesh/engine/mesh.hpp>
#include <tilemesh/splat/frame_program.hpp>

namespace leave_out {
using namespace tilemesh;

struct Run : Lossless {
    using Machine = MACHINE;
};
RunCounters run(Mesh<Frame<Run>, Run::Machine>& mesh, CheckedMesh<Frame<Run>, Run::Machine>& checked)
{
    checked.run();
    return mesh.run();
}

// Not a byte of a tile either: region by region.
using Here = Tile<Run::Machine, Frame<Run>, Run>;
using Plain = Tile<Mk2, Frame<Lossless>, Lossless>;
constexpr bool same_ledger() noexcept
{
    if (Here::bytes != Plain::bytes || Here::state_words != Plain::state_words || Here::region_count != Plain::region_count) return false;
    for (std::uint32_t i = 0; i < Plain::region_count; ++i)
        if (Here::ledger()[i].bytes != Plain::ledger()[i].bytes || Here::ledger()[i].name.size != Plain::ledger()[i].name.size) return false;
    return true;
}
static_assert(same_ledger(), "a trace is the host's: it takes nothing of a tile's SRAM");
} // namespace leave_out
