#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>

// Parts of model/ that users do not need. Not tilemesh::model::detail: a namespace `model` would clash with every user's function of
// that name after `using namespace tilemesh`.
namespace tilemesh::model_detail {

/// Throws `Error` where the trace names a step or a tile that is not there.
inline void check_trace(Trace const& trace, Grid grid)
{
    auto const fail = [](std::size_t superstep, std::string const& why) {
        throw Error("cannot read the trace (superstep " + std::to_string(superstep) + " ran " + why +
                    "); give the trace and the grid of one run");
    };
    for (std::size_t i = 0; i < trace.supersteps.size(); ++i) {
        auto const& s = trace.supersteps[i];
        if (s.step >= trace.kernels.size())
            fail(i, "step " + std::to_string(s.step) + " of a program of " + std::to_string(trace.kernels.size()));
        for (auto const& t : s.tiles)
            if (t.tile >= grid.size())
                fail(i, "tile " + std::to_string(t.tile) + " of a grid of " + std::to_string(grid.width) + " x " +
                            std::to_string(grid.height));
    }
}

inline std::uint64_t all_sent(TileSample const& t) noexcept
{
    std::uint64_t bytes = 0;
    for (Direction d : news) bytes += t.sent_bytes[index(d)];
    return bytes;
}

} // namespace tilemesh::model_detail
