#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tilemesh/engine/trace.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/machine/grid.hpp>
#include <tilemesh/machine/operations.hpp>
#include <vector>

// Parts of model/ that users do not need. The namespace is not tilemesh::model::detail, because after `using namespace tilemesh` a
// namespace `model` would clash with every user's function of that name.
namespace tilemesh { inline namespace v0_2 { namespace model_detail {

/// The names of the operations that the kernel of a step counts. Empty for a step without names, in a trace made by hand.
inline std::vector<std::string> const& operations_of_step(Trace const& trace, std::size_t step) noexcept
{
    static std::vector<std::string> const none;
    return step < trace.operations.size() ? trace.operations[step] : none;
}

/// Throws `Error` if the trace names a step or a tile that does not exist, or more operations of a kernel than a kernel can count.
inline void check_trace(Trace const& trace, Grid grid)
{
    auto const fail = [](std::size_t superstep, std::string const& why) {
        throw Error("cannot read the trace (superstep " + std::to_string(superstep) + " ran " + why + "); give the trace and the grid of one run");
    };
    for (auto const& names : trace.operations)
        if (names.size() > most_operation_kinds)
            throw Error("cannot read the trace (a kernel names " + std::to_string(names.size()) + " operations, and " +
                        std::to_string(most_operation_kinds) + " can be counted); give the trace of a run");
    for (std::size_t i = 0; i < trace.supersteps.size(); ++i) {
        auto const& s = trace.supersteps[i];
        if (s.step >= trace.kernels.size()) fail(i, "step " + std::to_string(s.step) + " of a program of " + std::to_string(trace.kernels.size()));
        for (auto const& t : s.tiles)
            if (t.tile >= grid.size())
                fail(i, "tile " + std::to_string(t.tile) + " of a grid of " + std::to_string(grid.width) + " x " + std::to_string(grid.height));
    }
}

/// The operations of all steps, each name once, in the order in which the steps name them, and the columns of each step's operations.
struct OperationColumns {
    std::vector<std::string> names;
    std::vector<std::array<std::uint32_t, most_operation_kinds>> of_step;
    explicit OperationColumns(Trace const& trace)
    {
        for (std::uint32_t step = 0; step < trace.kernels.size(); ++step) {
            auto& at = of_step.emplace_back();
            auto const& own = operations_of_step(trace, step);
            for (std::size_t kind = 0; kind < own.size() && kind < at.size(); ++kind) {
                auto const known = std::find(names.begin(), names.end(), own[kind]);
                at[kind] = static_cast<std::uint32_t>(known - names.begin());
                if (known == names.end()) names.push_back(own[kind]);
            }
        }
    }
};

inline std::uint64_t all_sent(TileSample const& t) noexcept
{
    std::uint64_t bytes = 0;
    for (Direction d : news) bytes += t.sent_bytes[index(d)];
    return bytes;
}

}}} // namespace tilemesh::v0_2::model_detail
